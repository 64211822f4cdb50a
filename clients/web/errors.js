// Which errors on purpose are in force, for viewers who may see the truth: a blind test stays blind.

import { Order, callApi } from "./api.js";

const PARTS = ["gyro", "log", "position", "antenna", "feed"];

export function errorsPanel(page) {
  const requests = new Order();
  const show = async () => {
    const { id } = page.radar;
    const turn = requests.next();
    const path = `radars/${encodeURIComponent(id)}/errors`;
    const tables = page.givesTruth ? await callApi(path).catch(() => ({})) : {};
    if (requests.isNewest(turn) && page.radar.id === id) showParts(page.givesTruth ? tables : {});
  };
  return { changes: ["errors"], changed: show, hello: show };
}

/** tables: as REST gives them, null where a part has none. */
function showParts(tables) {
  const parts = PARTS.filter((name) => tables[name]);
  const text = document.getElementById("errors-text");
  text.textContent = parts.length ? `Errors: ${parts.join(", ")}` : "";
  text.hidden = parts.length === 0;
}
