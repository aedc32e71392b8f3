// What comparing the browser's cells with the server's found.

/** Where cells are compared with the server's, what came out. */
export interface Check {
  tiles: number;
  cells: number;
  membership: number;
  values: number;
  largest: number;
}

export const none = (): Check => ({ tiles: 0, cells: 0, membership: 0, values: 0, largest: 0 });

export function add(a: Check, b: Check): Check {
  return {
    tiles: a.tiles + b.tiles,
    cells: a.cells + b.cells,
    membership: a.membership + b.membership,
    values: a.values + b.values,
    largest: Math.max(a.largest, b.largest),
  };
}
