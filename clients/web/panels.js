// The panels of the page, in their order. To add one, write a file beside this one, and list its function here.
//
// A panel is a function of the page, called once: a record {settings, scope, radar, origin, givesTruth, fidelity}, the last four
// by the last hello. It returns what it has, all of it optional:
//   element               put into the column of controls, before "Feed"
//   changes               the kinds of changes of the radar that it wants: "status", "controls", "scene", "commands", "errors"
//   changed(change)       after one of these on the radar that the page shows: {kind, values, time}
//   hello(message)        at the start of each connection and epoch
//   settingChanged(name)  after the user has changed a setting of the page
//   second()              every second
//   forget()              removes what a service that has ended had to say

import { errorsPanel } from "./errors.js";
import { scenesPanel } from "./scenes.js";
import { targetsPanel } from "./targets.js";

export const PANELS = [scenesPanel, targetsPanel, errorsPanel];

export class Panels {
  /** panels: what the functions above return; before: the element before which theirs are put. */
  constructor(panels, before) {
    this.panels = panels;
    before.before(...panels.flatMap(({ element }) => element ?? []));
  }

  /** Calls a function of all panels that have it. */
  tell(name, ...details) {
    for (const panel of this.panels) panel[name]?.(...details);
  }

  /** Tells a change of the radar to the panels that want its kind. */
  changed(change) {
    for (const panel of this.panels) if (panel.changes?.includes(change.kind)) panel.changed(change);
  }
}
