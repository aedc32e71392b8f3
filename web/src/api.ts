// The server's answers, as promises; every path is relative to the page's own address.

import type { Cell, GoAsk, GpuCheck, GpuPlan, History, LaneAsk, Session, State, Working } from "./protocol";

/** What went wrong, in the server's words. */
export class ServerError extends Error {}

let open = 0;

/** How many questions are not yet answered. */
export function unanswered(): number {
  return open;
}

async function failure(response: Response): Promise<ServerError> {
  const text = await response.text().catch(() => "");
  try {
    const told: unknown = JSON.parse(text);
    if (typeof told === "object" && told !== null && "error" in told && typeof told.error === "string") {
      return new ServerError(told.error);
    }
  } catch {
    // Not JSON: the status must do.
  }
  return new ServerError(`the server answered ${response.status} ${response.statusText}`.trim());
}

async function ask<T>(path: string, init: RequestInit, take: (response: Response) => Promise<T>): Promise<T> {
  open += 1;
  try {
    const response = await fetch(path, init).catch((e: unknown) => {
      if (init.signal?.aborted) throw e;
      throw new ServerError("the server does not answer: is echogrid view still running?");
    });
    if (!response.ok) throw await failure(response);
    return await take(response);
  } finally {
    open -= 1;
  }
}

const json = <T>(response: Response): Promise<T> => response.json() as Promise<T>;

function post<T>(path: string, body: unknown): Promise<T> {
  const headers = { "content-type": "application/json" };
  return ask(path, { method: "POST", headers, body: JSON.stringify(body) }, json<T>);
}

function postBytes<T>(
  path: string,
  body: Uint8Array<ArrayBuffer>,
  take: (response: Response) => Promise<T>,
): Promise<T> {
  return ask(path, { method: "POST", headers: { "content-type": "application/octet-stream" }, body }, take);
}

const get = <T>(path: string, signal?: AbortSignal): Promise<T> => ask(path, signal ? { signal } : {}, json<T>);
const bytes = (response: Response): Promise<ArrayBuffer> => response.arrayBuffer();

export const api = {
  session: () => get<Session>("api/session"),
  go: (where: GoAsk, budget: number) => post<State>("api/go", { ...where, budget_ms: budget }),
  lanes: (lanes: LaneAsk[]) => post<Session>("api/lanes", { lanes }),
  cell: (column: number, row: number, signal?: AbortSignal) =>
    get<Cell>(`api/cell?column=${column}&row=${row}`, signal),
  working: (lane: number) => get<Working>(`api/working?lane=${lane}`),
  history: (lane: number, column: number, row: number, count: number) =>
    get<History>(`api/history?lane=${lane}&column=${column}&row=${row}&count=${count}`),
  /** A tile's picture; `null` where nothing was ever reached. */
  tile: (path: string, signal: AbortSignal) =>
    ask(path, { signal }, async (r) => (r.status === 204 ? null : createImageBitmap(await r.blob()))),
  plan: (lane: number) => get<GpuPlan>(`api/gpu/plan?lane=${lane}`),
  batch: (lane: number, from: number, to: number) => ask(`api/gpu/batch?lane=${lane}&from=${from}&to=${to}`, {}, bytes),
  wgsl: (path: string) => ask(path, {}, (r) => r.text()),
  share: (lane: number, from: number, to: number, counts: Uint8Array<ArrayBuffer>) =>
    postBytes(`api/gpu/share?lane=${lane}&from=${from}&to=${to}`, counts, bytes),
  words: (lane: number, to: number, words: Uint8Array<ArrayBuffer>) =>
    postBytes(`api/gpu/words?lane=${lane}&to=${to}`, words, json<GpuCheck>),
  reset: (lane: number) =>
    ask(`api/gpu/reset?lane=${lane}`, { method: "POST" }, async (r) => {
      await r.arrayBuffer();
    }),
};
