// The controls that act on this page only: settings and framing.

import { keep } from "./settings.js";
import { announce } from "./status.js";

const LISTS = ["orientation", "motion", "stabilisation", "afterglow", "unit", "palette", "trails", "trailmotion", "detail"];
const CHECKS = ["rings", "headline", "sweep", "truth", "keys"];
const ZOOM_STEP = 2;
const element = (id) => document.getElementById(id);

export class Preferences {
  /** changed(name, value): called after a setting changes; name is "framing" after zoom or centre change. */
  constructor(scope, changed) {
    this.scope = scope;
    this.settings = scope.settings;
    this.changed = changed;
    this.show();
    this.bind();
  }

  bind() {
    for (const name of LISTS) element(name).onchange = () => this.choose(name, element(name).value);
    for (const name of CHECKS) element(name).onchange = () => this.choose(name, element(name).checked ? "on" : "off");
    element("zoom-in").onclick = () => this.zoom(ZOOM_STEP);
    element("zoom-out").onclick = () => this.zoom(1 / ZOOM_STEP);
    element("look-ahead").onclick = () => this.lookAhead();
    element("centre").onclick = () => this.frame(() => this.scope.framing.reset());
    element("clear").onclick = () => this.frame(() => (this.scope.marker = null));
    element("clear-trails").onclick = () => this.scope.startTrails(false);
  }

  choose(name, value) {
    keep(this.settings, name, value);
    if (name === "palette") {
      document.documentElement.dataset.palette = value;
      this.scope.repaint();
    }
    if (name === "orientation" || name === "motion") this.scope.framing.moveTo({ x: 0, y: 0 }, 1); // axes have other bearings
    if (name === "detail") this.scope.fit();
    if (name === "stabilisation") this.scope.restartMotion();
    if (name === "trails" || name === "trailmotion") this.scope.startTrails(true);
    this.scope.changed = true;
    this.show();
    this.changed(name, value);
  }

  show() {
    for (const name of LISTS) element(name).value = this.settings[name];
    for (const name of CHECKS) element(name).checked = this.settings[name] === "on";
    element("motion").disabled = this.settings.orientation !== "north-up"; // true motion is defined with north up
    element("trailmotion").disabled = element("clear-trails").disabled = this.settings.trails === "0";
  }

  /** Selects the next option of a list and announces it to screen readers. */
  next(name) {
    const values = [...element(name).options].map((option) => option.value);
    this.choose(name, values[(values.indexOf(this.settings[name]) + 1) % values.length]);
    announce(element(name).selectedOptions[0].textContent);
  }

  frame(change) {
    change();
    this.scope.changed = true;
    this.changed("framing");
  }

  zoom(factor) {
    this.frame(() => this.scope.framing.zoomBy(factor, this.scope.view));
    announce(`Zoom ${this.scope.framing.zoom.toFixed(1)}`);
  }

  lookAhead() {
    const { framing, ship, view } = this.scope;
    this.frame(() => framing.lookAhead(ship.heading - view.up, view));
    announce("Own ship off the centre");
  }
}
