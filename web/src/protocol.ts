// What page and server say to each other; README.md is the text of it.

/** Column and row, counted from the lower left; fractions inside a cell. */
export type Place = [number, number];
/** x, y in metres, heading in radians. */
export type Pose = [number, number, number];

export interface Grid {
  x0: number;
  y0: number;
  resolution: number;
  width: number;
  height: number;
}

export interface ScaleLegend {
  kind: "scale";
  stops: [string, string][];
  untouched: string;
}

export interface ClassLegend {
  kind: "classes";
  entries: [string, string][];
  untouched: string;
}

export interface View {
  name: string;
  about: string;
  group: "main" | "layer";
  legend: ScaleLegend | ClassLegend;
}

export interface Source {
  name: string;
  views: View[];
  /** Of a log: the lane's method and parameters. */
  method?: string;
  set?: Record<string, string>;
  parameters?: Record<string, string>;
  /** Of a map. */
  kind?: "map" | "truth";
}

export interface Key {
  name: string;
  values: string;
  default: string;
  about: string;
}

export interface Method {
  name: string;
  about: string;
  source: string;
  keys: Key[];
}

export interface Outline {
  sensor: Place;
  axis: [Place, Place];
  lines: Place[][];
}

export interface Part {
  feature: string;
  weight: number;
  free: Place[] | null;
  occupied: [Place, Place][];
}

export interface Routine {
  weight: number;
  free: Place[] | null;
  arc: Place[] | null;
  occupies: boolean;
}

export interface Case {
  name: string;
  about: string;
  parts: Part[];
  routine: Routine | null;
}

export interface CurrentReading {
  kind: "reading";
  number: number;
  line: number;
  scan: number;
  t: number | null;
  sensor: string;
  robot: Pose;
  pose: Pose;
  z: number | null;
  outcome: "hit" | "no_echo";
  range: number | null;
  half_width: number;
  outline: Outline | null;
  case?: Case | null;
}

export interface Beam {
  line: number;
  pose: Pose;
  range: number | null;
  label: number | null;
  ray: [Place, Place];
}

export interface CurrentScan {
  kind: "scan";
  number: number;
  line: number;
  scan: number;
  t: number | null;
  robot: Pose;
  robot_cell: Place;
  beams: Beam[];
}

export type Current = CurrentReading | CurrentScan;

export interface LaneState {
  position: number;
  total: number;
  changed: Place[] | "all";
  current: Current | null;
}

/** What an answer is of: the lanes as they were made, and their place in the log. */
export type Dated = { version: number; generation: number };

export interface State extends Dated {
  position: number;
  total: number;
  scan: number;
  scans: number;
  done: boolean;
  /** Where it was asked to go, while not done. */
  target?: number;
  lanes: LaneState[];
}

export type Json = string | number | boolean | null | Json[] | { [key: string]: Json };

export interface Session {
  mode: "log" | "map";
  name: string;
  version: string;
  grid: Grid;
  levels: number;
  sources: Source[];
  difference: View | null;
  /** Of a log. */
  generation?: number;
  methods?: Method[];
  sensor_keys?: Key[];
  sensors?: { [key: string]: Json }[];
  state?: State;
  /** Of a log: `readings` and `bad_lines`; of a map its report.json. */
  report?: { [key: string]: Json };
  score?: { [key: string]: Json } | null;
}

/** A pose and a beam of it that speak of a cell; other fields are shown as they come. */
export interface Chosen {
  pose?: Pose;
  ray?: [Place, Place];
  gained?: [string, number][];
  [key: string]: Json | undefined;
}

export interface CellSource {
  name: string;
  touched: boolean;
  class: string;
  interior?: number;
  arc?: number;
  values: [string, number | string | null][];
  chosen?: Chosen[];
}

export interface Cell extends Partial<Dated> {
  column: number;
  row: number;
  x: number;
  y: number;
  sources: CellSource[];
}

export type Step = "own" | "cancelled" | "normalised";

export interface Working extends Dated {
  position: number;
  interior: number;
  arc: number;
  n: number | null;
  sum: number | null;
  own_is: string;
  layers: string[];
  steps: Step[];
  truncated: boolean;
  column: number[];
  row: number[];
  /** 0 interior, 1 arc. */
  region: number[];
  d: (number | null)[];
  theta: (number | null)[];
  own: (number | null)[];
  cancelled?: (number | null)[];
  normalised?: (number | null)[];
  strength: (number | null)[];
  /** What the shade is of, and its value where it is strongest. */
  strongest: number | null;
  strength_is: string;
  before: (number | null)[][];
  after: (number | null)[][];
  chosen?: Chosen[][];
}

export interface HistoryEvent {
  number: number;
  line: number;
  scan: number;
  t: number | null;
  sensor: string;
  outcome: string;
  range: number | null;
  region: "interior" | "arc";
  own: number | null;
  before: (number | null)[];
  after: (number | null)[];
}

export interface History extends Dated {
  total: number;
  layers: string[];
  events: HistoryEvent[];
  note: string | null;
}

export interface LaneAsk {
  method: string;
  set: Record<string, string>;
}

/** Where to go; `since` is added by who asks. */
export type GoAsk = { by: "reading" | "scan"; count: number } | { to: number };
