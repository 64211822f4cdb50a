// The REST side of the service. Addresses are relative to the page, so that it also works behind a path of a proxy.

const KEPT = "radar-token"; // for this tab alone
let token = sessionStorage.getItem(KEPT) ?? "";

/** The token that every request carries from now on; empty for none. */
export function useToken(text) {
  token = text.trim();
  sessionStorage.setItem(KEPT, token);
}

/** Answers the JSON of an address under api/. Throws an Error with the service's own words where it refuses.
 *  Where it wants a token the document hears of it by the event "token-wanted". */
export function ask(path, method = "GET", body = undefined) {
  if (body === undefined) return request(path, { method, headers: {} });
  return request(path, { method, headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
}

/** Posts a form with files, and answers as `ask` does. */
export const send = (path, form) => request(path, { method: "POST", headers: {}, body: form });

async function request(path, options) {
  if (token) options.headers.Authorization = `Bearer ${token}`;
  const answer = await fetch(new URL(`api/${path}`, document.baseURI), options);
  if (answer.status === 401) document.dispatchEvent(new Event("token-wanted"));
  const text = await answer.text();
  if (!answer.ok) throw new Error(refusal(text) || `${options.method} ${path}: the service answered ${answer.status}`);
  return text ? JSON.parse(text) : null;
}

function refusal(text) {
  try {
    const { detail } = JSON.parse(text);
    if (Array.isArray(detail)) return detail.map(String).join("\n");
    return detail ?? "";
  } catch {
    return ""; // not JSON: a proxy's page, say
  }
}

/** The websocket address of a radar's feed, with a ticket that opens it once where there is a token.
 *  since: "EPOCH:SEQ" to go on from, or empty; truth: whether to ask for that too. */
export async function feedAddress(radar, bins, since, truth) {
  const ticket = token ? (await ask("tickets", "POST")).ticket : "";
  const address = new URL(`api/radars/${encodeURIComponent(radar)}/feed`, document.baseURI);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  address.searchParams.set("encoding", "u8");
  address.searchParams.set("bins", bins);
  if (truth) address.searchParams.set("truth", "1");
  if (since) address.searchParams.set("since", since);
  if (ticket) address.searchParams.set("ticket", ticket);
  return address.href;
}
