// The server's answers, as promises; every path is relative to the page's own address.

import type {
  Cell,
  GoRequest,
  GpuCheck,
  GpuPlan,
  History,
  LaneSpec,
  LanesRequest,
  Session,
  Stamp,
  State,
  StepUnit,
  Working,
} from "./generated/protocol";


/** Where to go in a log: by so many readings or scans, or to a position. */
export type GoTarget = { by: StepUnit; count: number } | { to: number };

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
    const body: unknown = JSON.parse(text);
    if (typeof body === "object" && body !== null && "error" in body && typeof body.error === "string") {
      return new ServerError(body.error);
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

/** Hears what each answer of a log is of; elsewhere.ts listens. */
export const heard = { hear: (_: Stamp): void => {} };

/** An answer of a log carries its stamp, one of a map doesn't. */
async function stamped<T>(response: Response): Promise<T> {
  const answer = (await response.json()) as T & Partial<Stamp>;
  const { version, generation } = answer;
  if (version !== undefined && generation !== undefined) heard.hear({ version, generation });
  return answer;
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

const getStamped = <T>(path: string, signal?: AbortSignal): Promise<T> =>
  ask(path, signal ? { signal } : {}, stamped<T>);
const get = <T>(path: string): Promise<T> => ask(path, {}, json<T>);
const bytes = (response: Response): Promise<ArrayBuffer> => response.arrayBuffer();

export const api = {
  session: () => get<Session>("api/session"),
  /** `since` is the version that the page stands at: where the server's is another, all may have changed. */
  go: (where: GoTarget, since: number | undefined, budget: number) =>
    post<State>("api/go", { ...where, since, budget_ms: budget } satisfies GoRequest),
  lanes: (lanes: LaneSpec[]) => post<Session>("api/lanes", { lanes } satisfies LanesRequest),
  cell: (column: number, row: number, signal?: AbortSignal) =>
    getStamped<Cell>(`api/cell?column=${column}&row=${row}`, signal),
  working: (lane: number) => getStamped<Working>(`api/working?lane=${lane}`),
  history: (lane: number, column: number, row: number, count: number) =>
    getStamped<History>(`api/history?lane=${lane}&column=${column}&row=${row}&count=${count}`),
  /** A tile's picture; `null` where nothing was ever reached. */
  tile: (path: string, signal: AbortSignal) =>
    ask(path, { signal }, async (r) => (r.status === 204 ? null : createImageBitmap(await r.blob()))),
  plan: (lane: number) => get<GpuPlan>(`api/gpu/plan?lane=${lane}`),
  batch: (lane: number, from: number, to: number) => ask(`api/gpu/batch?lane=${lane}&from=${from}&to=${to}`, {}, bytes),
  wgsl: (path: string) => ask(path, {}, (r) => r.text()),
  share: (lane: number, from: number, to: number, counts: Uint8Array<ArrayBuffer>) =>
    postBytes(`api/gpu/share?lane=${lane}&from=${from}&to=${to}`, counts, bytes),
  /** `more`: of this position other words follow. */
  words: (lane: number, to: number, words: Uint8Array<ArrayBuffer>, more: boolean) =>
    postBytes(`api/gpu/words?lane=${lane}&to=${to}${more ? "&more=1" : ""}`, words, json<GpuCheck>),
  reset: (lane: number) =>
    ask(`api/gpu/reset?lane=${lane}`, { method: "POST" }, async (r) => {
      await r.arrayBuffer();
    }),
};
