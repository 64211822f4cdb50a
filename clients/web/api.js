// Requests to the REST interface. Addresses are relative to the page, so that it also works behind a path of a proxy.

const TOKEN_KEY = "radar-token"; // in this tab's storage only
let token = sessionStorage.getItem(TOKEN_KEY) ?? "";

/** Sets the token that every later request carries; empty for none. */
export function useToken(text) {
  token = text.trim();
  sessionStorage.setItem(TOKEN_KEY, token);
}

/** Returns the JSON of an address under api/. Throws an Error with the service's message if it refuses the request, and
 *  NoAnswer if there is no service.
 *  Dispatches the event "token-required" on the document if the service requires a token. */
export function callApi(path, method = "GET", body = undefined) {
  if (body === undefined) return fetchJson(path, { method, headers: {} });
  return fetchJson(path, { method, headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
}

/** Posts a form with files; returns and throws as `callApi` does. */
export const postForm = (path, form) => fetchJson(path, { method: "POST", headers: {}, body: form });

/** The radar's service does not answer. */
export class NoAnswer extends Error {
  constructor() {
    super("the radar's service does not answer");
  }
}

/** The order of requests that ask for the same, whose answers may overtake each other. */
export class Order {
  constructor() {
    this.asked = 0;
    this.answered = 0;
  }

  /** Returns the number of a new request. */
  next() {
    return ++this.asked;
  }

  /** Whether no later request has been answered. */
  isNewest(number) {
    if (number < this.answered) return false;
    this.answered = number;
    return true;
  }
}

async function fetchJson(path, options) {
  if (token) options.headers.Authorization = `Bearer ${token}`;
  const response = await fetch(new URL(`api/${path}`, document.baseURI), options).catch(() => {
    throw new NoAnswer(); // browsers say "Failed to fetch"
  });
  if (response.status === 401) document.dispatchEvent(new Event("token-required"));
  const text = await response.text();
  if (!response.ok) throw new Error(refusal(text) || `${options.method} ${path}: the service answered ${response.status}`);
  return text ? JSON.parse(text) : null;
}

function refusal(text) {
  try {
    const { detail } = JSON.parse(text);
    if (Array.isArray(detail)) return detail.map(String).join("\n");
    return detail ?? "";
  } catch {
    return ""; // not JSON, for example a proxy's page
  }
}

/** Returns the websocket address of a radar's feed. With a token it carries a ticket, which is valid once.
 *  view: parameters of the feed by name; since: "EPOCH:SEQ" from which the feed continues, or empty; truth: whether to request
 *  truth messages. */
export async function feedAddress(radar, view, since, truth) {
  const address = await socketAddress(`radars/${encodeURIComponent(radar)}/feed`);
  for (const [name, value] of Object.entries({ encoding: "u8", ...view })) address.searchParams.set(name, value);
  if (truth) address.searchParams.set("truth", "1");
  if (since) address.searchParams.set("since", since);
  return address.href;
}

/** Returns the websocket address under api/ as a URL. With a token it carries a ticket, which is valid once. */
export async function socketAddress(path) {
  const ticket = token ? (await callApi("tickets", "POST")).ticket : "";
  const address = new URL(`api/${path}`, document.baseURI);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  if (ticket) address.searchParams.set("ticket", ticket);
  return address;
}
