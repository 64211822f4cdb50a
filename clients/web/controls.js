// The controls that act on the radar itself, for all its clients. The page sends them as PATCH requests, one at a time; those
// that a new engine is prepared for have a lane of their own, so that no other one waits for them.

import { NoAnswer, Order, callApi } from "./api.js";
import { Lane } from "./lane.js";
import { changesByOthers } from "./other_viewers.js";
import { dismiss, toast } from "./toast.js";
import { rangeScales, rangeText, scaleFor } from "./units.js";
import { buildWidgets } from "./widgets.js";

const PREPARING = "preparing an engine"; // topic of a message
const element = (id) => document.getElementById(id);

export class Controls {
  /** unit(): "nm" or "m"; changed(): called after the radar's state may have changed. */
  constructor(unit, changed) {
    this.unit = unit;
    this.changes = ["status", "controls", "scene"]; // as a panel: see panels.js
    this.stateChanged = changed;
    this.definitions = [];
    this.sent = {}; // values that the radar may still tell as new
    this.declared = ""; // the definitions as JSON
    this.widgets = {}; // by name of the control: the function that shows its value
    this.state = {};
    this.health = null;
    this.engine = new Lane((change) => this.patch(change)); // takes seconds
    this.others = new Lane((change) => this.patch(change));
    this.version = 0; // grows with each hello and change: answers to earlier requests are out of date
    this.refreshes = new Order();
    this.bind();
  }

  bind() {
    element("range").onchange = () => this.sendRange(Number(element("range").value));
    element("range-up").onclick = () => this.stepRange(1);
    element("range-down").onclick = () => this.stepRange(-1);
    element("pause").onclick = () => this.togglePause();
    element("step").onclick = () => this.send({ pace: { state: "step", steps: this.azimuths } });
    element("factor").onchange = () => {
      const { value } = element("factor");
      this.send({ pace: { factor: value === "max" ? value : Number(value) } });
    };
  }

  /** Adopts the radar and the controls of a hello; the limits of its scene are fetched. */
  hello(hello) {
    const title = JSON.stringify([hello.radar.id, hello.scene.name]);
    this.version++;
    this.radar = hello.radar.id;
    this.azimuths = hello.radar.azimuths;
    if (title === this.title) this.tellOthers(hello.controls);
    this.title = title;
    this.show(hello.controls);
    this.refresh();
  }

  /** Says what other viewers have changed, when `after` is the new state. */
  tellOthers(after) {
    const own = { ...this.sent, ...this.engine.requested, ...this.others.requested };
    const texts = changesByOthers(this.definitions, this.state, after, own, this.unit());
    for (const text of texts) toast(text, { topic: text.split(" ")[0] });
  }

  /** Adopts the definitions of a radar's controls. Elements are built anew only where a definition changed. */
  declare(definitions) {
    const text = JSON.stringify(definitions);
    if (text === this.declared) return;
    this.declared = text;
    this.definitions = definitions;
    this.rangeLimits = definitions.find(({ name }) => name === "range_m");
    this.widgets = buildWidgets(definitions, (change) => this.send(change));
    for (const name of ["gain", "sea"]) this.showAutomatic(name);
  }

  /** Lets a control show "auto" in place of its value while its automatic is on. */
  showAutomatic(name) {
    const show = this.widgets[name];
    if (!show) return;
    this.widgets[name] = (...shown) => {
      show(...shown);
      if (this.state[`${name}_auto`]) element(`${name}-value`).value = "auto";
    };
  }

  settingChanged(name) {
    if (name === "unit") this.showRanges();
  }

  forget() {
    this.health = null;
  }

  /** Takes the status; of other changes it refreshes once for all that come together. */
  changed({ kind, values }) {
    if (kind === "status") {
      this.health = values;
      return;
    }
    this.soon ??= setTimeout(() => {
      this.soon = undefined;
      this.refresh();
    });
  }

  /** Fetches definitions and controls, which other clients may have changed, and the radar's health. */
  async refresh() {
    const { radar: id, version } = this;
    if (id === undefined || this.others.busy) return;
    const turn = this.refreshes.next();
    const requests = [callApi("health"), callApi(`radars/${encodeURIComponent(id)}`)];
    const [health, radar] = await Promise.all(requests.map((one) => one.catch(() => null))); // the feed reports a lost connection
    if (!this.refreshes.isNewest(turn)) return;
    this.health = health?.radars.find((one) => one.id === id) ?? null;
    if (!radar || this.version !== version) return;
    this.declare(radar.control_definitions);
    this.tellOthers(radar.controls);
    this.sent = {};
    this.show(radar.controls);
  }

  /** The factor that the service reaches if it is slower than requested; null if it keeps its pace. */
  get behind() {
    return this.health?.state === "behind" ? this.health.factor_reached : null;
  }

  /** The text of the fastest pace on offer that a service that is too slow reaches; "" for none. */
  get slower() {
    const reached = [...element("factor").options].filter(({ value }) => Number(value) <= this.behind); // not "max"
    return reached.at(-1)?.textContent ?? "";
  }

  togglePause() {
    this.send({ pace: { state: this.paused ? "run" : "pause" } });
  }

  stepRange(by) {
    const scales = this.rangeScales();
    const next = scales[scales.indexOf(this.rangeScale()) + by];
    if (next) this.sendRange(next);
  }

  /** Sends a range scale [m]; on the longest one the radar gives all that it has. */
  sendRange(scale) {
    const { minimum, maximum } = this.rangeLimits;
    this.send({ range_m: scale === this.rangeScales().at(-1) ? maximum : Math.max(scale, minimum) });
  }

  /** The range scales of the radar [m], in the current unit. */
  rangeScales() {
    const { minimum, maximum } = this.rangeLimits;
    const shortest = scaleFor(minimum, this.unit());
    return rangeScales(maximum, this.unit()).filter((scale) => scale >= shortest);
  }

  /** The scale of the radar's present range [m]. */
  rangeScale() {
    return scaleFor(this.state.range_m ?? this.rangeLimits.maximum, this.unit());
  }

  get paused() {
    return this.state.pace?.state !== undefined && this.state.pace.state !== "run";
  }

  /** The requested factor of the pace; null if the service runs as fast as possible. */
  get factor() {
    const factor = this.state.pace?.factor ?? 1;
    return typeof factor === "number" ? factor : null;
  }

  /** Sends a change of one control. */
  async send(change) {
    this.version++;
    const changed = this.definitions.filter(({ name }) => name in change);
    const isPrepared = changed.some(({ acts_on }) => acts_on === "engine");
    const labels = changed.map(({ name, label, unit }) => `${label} ${change[name]} ${unit}`).join(", ");
    if (isPrepared) toast(`Preparing ${labels} …`, { isLasting: true, topic: PREPARING });
    const isTaken = await (isPrepared ? this.engine : this.others).send(change);
    if (isTaken === undefined) return;
    if (isPrepared) dismiss(PREPARING);
    if (!isTaken) this.show({}, true);
    await this.refresh();
  }

  /** Sends a change; returns whether the radar has taken it. */
  async patch(change) {
    this.sent = { ...this.sent, ...change };
    try {
      await callApi(`radars/${encodeURIComponent(this.radar)}/controls`, "PATCH", change);
      dismiss("command");
      return true;
    } catch (refused) {
      const labels = this.definitions.filter(({ name }) => name in change).map(({ label }) => label);
      const back = `${labels.join(", ")} not changed: ${refused.message}.`;
      toast(refused instanceof NoAnswer ? back : refused.message, { isAlert: true, topic: "command" });
      return false;
    }
  }

  /** Shows the state of the controls; isRefused: in place of a change that the radar has not taken. */
  show(controls, isRefused = false) {
    this.state = { ...this.state, ...controls };
    const shown = { ...this.state, ...this.engine.requested };
    for (const [name, show] of Object.entries(this.widgets)) show(shown[name], this.others.busy, isRefused);
    element("pause").ariaPressed = String(this.paused);
    element("step").disabled = !this.paused;
    element("factor").value = String(this.state.pace?.factor ?? 1);
    this.showRanges();
    this.stateChanged();
  }

  /** Fills the list of range scales in the current unit, and selects that of the radar. */
  showRanges() {
    if (!this.rangeLimits) return;
    const scales = this.rangeScales();
    const options = scales.map((scale) => new Option(rangeText(scale, this.unit()), scale));
    if (scales.join() !== this.offered) element("range").replaceChildren(...options);
    this.offered = scales.join();
    const current = scales.indexOf(this.rangeScale());
    element("range").selectedIndex = current;
    element("range-up").disabled = current === scales.length - 1;
    element("range-down").disabled = current === 0;
  }
}
