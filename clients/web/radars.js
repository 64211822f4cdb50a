// The list of the service's radars. The address names the one that is shown.

import { addressValue, setAddress } from "./address.js";
import { toast } from "./toast.js";

const element = (id) => document.getElementById(id);

/** The name of a radar: "Radar 0" where it has none of its own. */
export const radarName = ({ id, name }) => (!name || name === id ? `Radar ${id}` : name);

const titleOf = (radar) => (radar.scene ? `${radarName(radar)}: ${radar.scene.name}` : radarName(radar));

/** Whether the list has a radar of that id. */
export const isListed = (id) => [...element("radar").options].some(({ value }) => value === id);

/** Fills the list; returns the radar that was requested, by the address for example, else the first one, and says so.
 *  chosen(id): called when the user selects another radar; reason: why the one that was requested has gone. */
export function listRadars(radars, chosen, requested = addressValue("radar"), reason = "") {
  const selected = radars.find(({ id }) => id === requested) ?? radars[0];
  element("radar").replaceChildren(...radars.map((one) => new Option(titleOf(one), one.id, false, one === selected)));
  element("radar-row").hidden = radars.length < 2;
  element("radar").onchange = () => {
    setAddress({ radar: element("radar").value });
    chosen(element("radar").value);
  };
  if (requested !== null && selected.id !== requested) {
    toast(`${reason || `There is no radar “${requested}” here`}. This is ${titleOf(selected)}.`, { isAlert: !reason });
    setAddress({ radar: null });
  }
  return selected;
}

/** Shows the scene that a radar runs now in the list. */
export function renameRadar(radar, scene) {
  const option = [...element("radar").options].find(({ value }) => value === radar.id);
  if (option) option.textContent = titleOf({ ...radar, scene });
}
