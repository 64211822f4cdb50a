// The controls that act on the radar itself, for all its clients. The page sends them as PATCH requests, one at a time.

import { callApi } from "./api.js";
import { rangeScales, rangeText } from "./units.js";

const SLIDERS = ["gain", "sea", "rain"];
const element = (id) => document.getElementById(id);

export class Controls {
  /** showRefusal(text): shows why the service refused a change. unit(): "nm" or "m". */
  constructor(showRefusal, unit) {
    this.showRefusal = showRefusal;
    this.unit = unit;
    this.state = {};
    this.health = null;
    this.waiting = null;
    this.busy = false;
    this.bind();
  }

  bind() {
    for (const name of SLIDERS) {
      element(name).oninput = () => {
        element(`${name}-value`).value = element(name).value;
        this.send({ [name]: Number(element(name).value) });
      };
    }
    element("range").onchange = () => this.send({ range_m: Number(element("range").value) });
    element("range-up").onclick = () => this.stepRange(1);
    element("range-down").onclick = () => this.stepRange(-1);
    element("transmit").onclick = () => this.send({ transmit: !this.state.transmit });
    element("pause").onclick = () => this.togglePause();
    element("step").onclick = () => this.send({ pace: { state: "step", steps: this.azimuths } });
    element("factor").onchange = () => {
      const { value } = element("factor");
      this.send({ pace: { factor: value === "max" ? value : Number(value) } });
    };
    element("rpm").onchange = () => element("rpm").reportValidity() && this.send({ rpm: Number(element("rpm").value) });
  }

  /** Adopts the name, limits and controls of a hello. */
  adopt(hello) {
    this.radar = hello.radar.id;
    this.azimuths = hello.radar.azimuths;
    this.longest = hello.radar.range_max_m;
    this.show(hello.controls);
  }

  /** Fetches the controls, which other clients may have changed, and the radar's health. */
  async refresh() {
    if (this.radar === undefined || this.busy || this.waiting) return;
    const health = callApi("health").catch(() => null); // the feed reports a lost connection
    const controls = await callApi(`radars/${encodeURIComponent(this.radar)}/controls`).catch(() => null);
    this.health = (await health)?.radars.find((one) => one.id === this.radar) ?? null;
    if (controls && !this.busy) this.show(controls);
  }

  /** The factor that the service reaches if it is slower than requested; null if it keeps its pace. */
  get behind() {
    return this.health?.state === "behind" ? this.health.factor_reached : null;
  }

  togglePause() {
    this.send({ pace: { state: this.paused ? "run" : "pause" } });
  }

  stepRange(by) {
    const scales = rangeScales(this.longest, this.unit());
    const current = this.state.range_m ?? this.longest;
    const slack = current * 1e-3; // the radar's range differs from the requested scale by less than a cell
    const longer = (scale) => scale > current + slack;
    const shorter = (scale) => scale < current - slack;
    const next = by > 0 ? scales.find(longer) : scales.findLast(shorter);
    if (next) this.send({ range_m: next });
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
    for (const name of SLIDERS) {
      if (element(name) !== document.activeElement || !this.busy) element(name).value = this.state[name];
      element(`${name}-value`).value = element(name).value;
    }
    if (element("rpm") !== document.activeElement) element("rpm").value = this.state.rpm;
    element("transmit").ariaPressed = String(Boolean(this.state.transmit));
    element("transmit").textContent = this.state.transmit ? "Transmit" : "Standby";
    element("pause").ariaPressed = String(this.paused);
    element("pause").textContent = this.paused ? "Resume" : "Pause";
    element("step").disabled = !this.paused;
    element("factor").value = String(this.state.pace?.factor ?? 1);
    this.showRanges();
  }

  /** Fills the list of range scales in the current unit, with the radar's range if it is none of them. */
  showRanges() {
    if (!this.longest) return;
    const current = this.state.range_m ?? this.longest;
    const scales = rangeScales(this.longest, this.unit());
    const nearest = scales.find((scale) => Math.abs(scale - current) < current * 1e-3) ?? current;
    const offered = [...new Set([...scales, nearest])].sort((a, b) => a - b);
    const options = offered.map((scale) => new Option(rangeText(scale, this.unit()), scale, false, scale === nearest));
    if (element("range") !== document.activeElement) element("range").replaceChildren(...options);
    element("range-up").disabled = nearest >= this.longest * 0.999;
    element("range-down").disabled = nearest <= scales[0];
  }
}
