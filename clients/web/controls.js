// The controls that act on the radar itself, for all its clients. The page sends them as PATCH requests, one at a time.

import { callApi } from "./api.js";
import { rangeScales, rangeText } from "./units.js";
import { buildWidgets } from "./widgets.js";

const element = (id) => document.getElementById(id);

export class Controls {
  /** showRefusal(text): shows why the service refused a change. unit(): "nm" or "m". */
  constructor(showRefusal, unit) {
    this.showRefusal = showRefusal;
    this.unit = unit;
    this.declared = ""; // the definitions as JSON
    this.widgets = {}; // by name of the control: the function that shows its value
    this.state = {};
    this.health = null;
    this.waiting = null;
    this.busy = false;
    this.version = 0; // grows with each hello and change: answers to earlier requests are out of date
    this.bind();
  }

  bind() {
    element("range").onchange = () => this.send({ range_m: Number(element("range").value) });
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
  adopt(hello) {
    this.version++;
    this.radar = hello.radar.id;
    this.azimuths = hello.radar.azimuths;
    this.show(hello.controls);
    this.refresh();
  }

  /** Adopts the definitions of a radar's controls. Elements are built anew only where a definition changed. */
  declare(definitions) {
    const text = JSON.stringify(definitions);
    if (text === this.declared) return;
    this.declared = text;
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

  /** Fetches definitions and controls, which other clients may have changed, and the radar's health. */
  async refresh() {
    const { radar: id, version } = this;
    if (id === undefined || this.busy || this.waiting) return;
    const health = callApi("health").catch(() => null); // the feed reports a lost connection
    const radar = await callApi(`radars/${encodeURIComponent(id)}`).catch(() => null);
    this.health = (await health)?.radars.find((one) => one.id === id) ?? null;
    if (!radar || this.version !== version) return;
    this.declare(radar.control_definitions);
    this.show(radar.controls);
  }

  /** The factor that the service reaches if it is slower than requested; null if it keeps its pace. */
  get behind() {
    return this.health?.state === "behind" ? this.health.factor_reached : null;
  }

  togglePause() {
    this.send({ pace: { state: this.paused ? "run" : "pause" } });
  }

  stepRange(by) {
    const scales = this.rangeScales();
    const current = this.state.range_m ?? scales.at(-1);
    const slack = current * 1e-3; // the radar's range differs from the requested scale by less than a cell
    const longer = (scale) => scale > current + slack;
    const shorter = (scale) => scale < current - slack;
    const next = by > 0 ? scales.find(longer) : scales.findLast(shorter);
    if (next) this.send({ range_m: next });
  }

  /** The range scales that the radar allows [m], in the current unit. */
  rangeScales() {
    const { minimum, maximum } = this.rangeLimits;
    return rangeScales(maximum, this.unit()).filter((scale) => scale >= minimum);
  }

  get paused() {
    return this.state.pace?.state !== undefined && this.state.pace.state !== "run";
  }

  /** The requested factor of the pace; null if the service runs as fast as possible. */
  get factor() {
    const factor = this.state.pace?.factor ?? 1;
    return typeof factor === "number" ? factor : null;
  }

  /** Sends a change. Changes during a request are collected; the newest value of each control is sent next. */
  async send(change) {
    this.version++;
    this.waiting = { ...this.waiting, ...change };
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.waiting) await this.patch();
    } finally {
      this.busy = false;
    }
    await this.refresh();
  }

  async patch() {
    const change = this.waiting;
    this.waiting = null;
    try {
      await callApi(`radars/${encodeURIComponent(this.radar)}/controls`, "PATCH", change);
      this.showRefusal("");
    } catch (refused) {
      this.showRefusal(refused.message);
    }
  }

  show(controls) {
    this.state = { ...this.state, ...controls };
    for (const [name, show] of Object.entries(this.widgets)) show(this.state[name], this.busy);
    element("pause").ariaPressed = String(this.paused);
    element("pause").textContent = this.paused ? "Resume" : "Pause";
    element("step").disabled = !this.paused;
    element("factor").value = String(this.state.pace?.factor ?? 1);
    this.showRanges();
  }

  /** Fills the list of range scales in the current unit, with the radar's range if it is none of them. */
  showRanges() {
    if (!this.rangeLimits) return;
    const scales = this.rangeScales();
    const current = this.state.range_m ?? scales.at(-1);
    const nearest = scales.find((scale) => Math.abs(scale - current) < current * 1e-3) ?? current;
    const offered = [...new Set([...scales, nearest])].sort((a, b) => a - b);
    const options = offered.map((scale) => new Option(rangeText(scale, this.unit()), scale, false, scale === nearest));
    if (element("range") !== document.activeElement) element("range").replaceChildren(...options);
    element("range-up").disabled = nearest >= scales.at(-1) * 0.999;
    element("range-down").disabled = nearest <= scales[0];
  }
}
