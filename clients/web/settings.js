// The settings of this page: from the address (?orientation=head-up), else from the last visit, else the default. A setting
// that the user changes replaces the one in the address.

import { setAddress } from "./address.js";

const CHOICES = {
  orientation: ["north-up", "head-up", "course-up"],
  motion: ["relative", "true"],
  stabilisation: ["ground", "sea"],
  unit: ["nm", "m"],
  palette: ["multicolour", "dusk", "day", "night", "phosphor"],
  afterglow: ["2", "0", "0.25", "0.5", "1", "4"], // half-life in scans; 0: none
  rings: ["on", "off"],
  headline: ["on", "off"],
  sweep: ["on", "off"],
  trails: ["0", "30", "60", "180", "360"], // s; 0: none
  trailmotion: ["true", "relative"],
  detail: ["auto", "full"],
  truth: ["off", "on"],
  keys: ["on", "off"], // of one character
};

/** Loads the settings; the first choice of each is the default. */
export function loadSettings() {
  const address = new URLSearchParams(location.search);
  const settings = { sweep: matchMedia("(prefers-reduced-motion: reduce)").matches ? "off" : "on" };
  for (const [name, allowed] of Object.entries(CHOICES)) {
    const candidates = [address.get(name), stored(name), settings[name]];
    settings[name] = candidates.find((value) => allowed.includes(value)) ?? allowed[0];
  }
  return settings;
}

/** Changes a setting and stores it, here and in the address. */
export function keep(settings, name, value) {
  settings[name] = value;
  setAddress({ [name]: value });
  try {
    localStorage.setItem(`radar.${name}`, value);
  } catch {
    // without storage the setting lasts until the page is closed
  }
}

function stored(name) {
  try {
    return localStorage.getItem(`radar.${name}`);
  } catch {
    return null;
  }
}
