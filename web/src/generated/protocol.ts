// Generated from src/view/protocol; do not edit. ECHOGRID_WRITE_TYPESCRIPT=1 cargo test --lib view::protocol writes it anew.

/**
 * A point in cells: column and row, counted from the grid's lower left corner; a cell's centre lies at + 0.5.
 */
export type CellPoint = [number, number];

/**
 * A pose in the world frame: x and y in metres, heading in radians.
 */
export type WorldPose = [number, number, number];

/**
 * Any JSON.
 */
export type Json = string | number | boolean | null | Json[] | { [key: string]: Json };

/**
 * What an answer about a log refers to: the page compares it with its own.
 */
export type Stamp = {
/**
 * Increases whenever the position in the log changes, and with new lanes.
 */
version: number,
/**
 * Increases whenever the lanes are made anew.
 */
generation: number, };

/**
 * Sonar or laser.
 */
export type SensorKind = "sonar" | "laser";

/**
 * A session: a log being stepped through, or saved maps.
 */
export type Session = { "mode": "log" } & LogSession | { "mode": "map" } & MapSession;

/**
 * The session of a log.
 */
export type LogSession = {
/**
 * The log's file name.
 */
name: string,
/**
 * The version of echogrid.
 */
version: string,
/**
 * The grid of all lanes.
 */
grid: Grid,
/**
 * Levels of tiles: a pixel of level k covers 2^k × 2^k cells; the last level is one tile.
 */
levels: number,
/**
 * The lanes, one or two.
 */
sources: Array<LogSource>,
/**
 * Every method that a lane can run.
 */
methods: Array<MethodInfo>,
/**
 * The parameters of sensors that can be set.
 */
sensor_keys: Array<ParameterInfo>,
/**
 * The log's sensors.
 */
sensors: Array<SensorInfo>,
/**
 * The difference of two lanes, second minus first; `null` with one lane.
 */
difference: ViewInfo | null,
/**
 * Increases whenever the lanes are made anew.
 */
generation: number,
/**
 * What was read of the log.
 */
report: LogReport,
/**
 * The position in the log.
 */
state: State, };

/**
 * The session of saved maps.
 */
export type MapSession = {
/**
 * The first map's folder name.
 */
name: string,
/**
 * The version of echogrid.
 */
version: string,
/**
 * The first map's grid.
 */
grid: Grid,
/**
 * Levels of tiles: a pixel of level k covers 2^k × 2^k cells; the last level is one tile.
 */
levels: number,
/**
 * The map, and what is shown beside it.
 */
sources: Array<MapSource>,
/**
 * The difference of two maps, second minus first; `null` where there is none.
 */
difference: ViewInfo | null,
/**
 * The first map's report.json.
 */
report: Json,
/**
 * The first map's score, as `echogrid score --json` gives it; only with a truth.
 */
score?: Json, };

/**
 * A grid's place and size.
 */
export type Grid = {
/**
 * World x of the lower left corner, metres.
 */
x0: number,
/**
 * World y of the lower left corner, metres.
 */
y0: number,
/**
 * A cell's edge, metres.
 */
resolution: number,
/**
 * Columns.
 */
width: number,
/**
 * Rows.
 */
height: number, };

/**
 * A lane of a log: a method and its parameters.
 */
export type LogSource = {
/**
 * The name to show.
 */
name: string,
/**
 * The method.
 */
method: string,
/**
 * The parameters that the user set.
 */
set: { [key in string]: string },
/**
 * All parameters with their values.
 */
parameters: { [key in string]: string },
/**
 * What can be shown.
 */
views: Array<ViewInfo>, };

/**
 * A saved map, or a truth.
 */
export type MapSource = { "kind": "map",
/**
 * The name to show.
 */
name: string,
/**
 * The map's method.
 */
method: string,
/**
 * The map's folder.
 */
path: string,
/**
 * Whether its cells coincide with the first map's.
 */
aligned: boolean,
/**
 * What can be shown.
 */
views: Array<ViewInfo>, } | { "kind": "truth",
/**
 * The name to show.
 */
name: string,
/**
 * What can be shown.
 */
views: Array<ViewInfo>, };

/**
 * Something that can be shown of a source.
 */
export type ViewInfo = {
/**
 * Its name in requests.
 */
name: string,
/**
 * What it shows, with the unit.
 */
about: string,
/**
 * Where the page lists it.
 */
group: ViewGroup,
/**
 * Its colours.
 */
legend: Legend, };

/**
 * Where the page lists a view.
 */
export type ViewGroup = "main" | "layer";

/**
 * A view's colours, in CSS notation.
 */
export type Legend = { "kind": "scale",
/**
 * Values and their colours, evenly spaced, low to high.
 */
stops: Array<[string, string]>,
/**
 * The colour of cells that no reading reached.
 */
untouched: string, } | { "kind": "classes",
/**
 * Names and their colours.
 */
entries: Array<[string, string]>,
/**
 * The colour of cells that no reading reached.
 */
untouched: string, };

/**
 * A method.
 */
export type MethodInfo = {
/**
 * Its name.
 */
name: string,
/**
 * What it does.
 */
about: string,
/**
 * The publication.
 */
source: string,
/**
 * Its parameters.
 */
keys: Array<ParameterInfo>, };

/**
 * A parameter.
 */
export type ParameterInfo = {
/**
 * Its name.
 */
name: string,
/**
 * The values that it takes.
 */
values: string,
/**
 * Its default.
 */
default: string,
/**
 * What it does.
 */
about: string, };

/**
 * A sensor; lengths in metres, angles in radians.
 */
export type SensorInfo = {
/**
 * Its name in the log.
 */
id: string,
/**
 * Sonar or laser.
 */
kind: SensorKind,
/**
 * Half the beam's width.
 */
half_width: number | null,
/**
 * Shorter ranges are rejected.
 */
r_min: number | null,
/**
 * The farthest range.
 */
r_max: number | null,
/**
 * Longer ranges are no hit.
 */
hit_range: number | null,
/**
 * The range that a missing echo frees.
 */
no_echo_range: number | null,
/**
 * Half the arc's thickness.
 */
epsilon: number | null, };

/**
 * What was read of a log.
 */
export type LogReport = {
/**
 * Counts of readings: read, used, rejected and why.
 */
readings: Json,
/**
 * Lines that could not be read.
 */
bad_lines: BadLines, };

/**
 * Lines that could not be read.
 */
export type BadLines = {
/**
 * How many.
 */
count: number,
/**
 * What is wrong with the first of them.
 */
first: Array<string>, };

/**
 * The position in the log.
 */
export type State = {
/**
 * Items of the first lane that are applied.
 */
position: number,
/**
 * All items of the first lane.
 */
total: number,
/**
 * Scans begun so far.
 */
scan: number,
/**
 * All scans.
 */
scans: number,
/**
 * Whether the target is reached; false: the time budget ended first.
 */
done: boolean,
/**
 * The position that was asked for, in items of the first lane.
 */
target: number,
/**
 * Each lane's position.
 */
lanes: Array<LaneState>,
/**
 * Increases whenever the position in the log changes, and with new lanes.
 */
version: number,
/**
 * Increases whenever the lanes are made anew.
 */
generation: number, };

/**
 * A lane's position.
 */
export type LaneState = {
/**
 * Items that are applied.
 */
position: number,
/**
 * All items.
 */
total: number,
/**
 * Tiles of level 0 that changed since the last state.
 */
changed: ChangedTiles,
/**
 * The item that was applied last; `null` at the beginning.
 */
current: Current | null, };

/**
 * Tiles of level 0, of 256 × 256 cells.
 */
export type ChangedTiles = Array<[number, number]> | AllTiles;

/**
 * All tiles.
 */
export type AllTiles = "all";

/**
 * The item that was applied last.
 */
export type Current = { "kind": "reading" } & CurrentReading | { "kind": "scan" } & CurrentScan;

/**
 * A reading.
 */
export type CurrentReading = {
/**
 * Which item, from 1.
 */
number: number,
/**
 * Its line of the log.
 */
line: number,
/**
 * The log's number of its scan.
 */
scan: number,
/**
 * Its time, seconds.
 */
t: number | null,
/**
 * Its sensor.
 */
sensor: string,
/**
 * The kind of its sensor.
 */
sensor_kind: SensorKind,
/**
 * The robot's pose.
 */
robot: WorldPose,
/**
 * The sensor's pose.
 */
pose: WorldPose,
/**
 * The range in the log, metres; `null`: no echo.
 */
z: number | null,
/**
 * Hit or no echo.
 */
outcome: EchoOutcome,
/**
 * The range that is mapped, metres.
 */
range: number | null,
/**
 * Half the beam's width, radians.
 */
half_width: number | null,
/**
 * The outline of its cone; `null` where it lies outside the grid.
 */
outline: Outline | null,
/**
 * What features made of it; `null` for other methods.
 */
case: FeatureCase | null, };

/**
 * Hit or no echo.
 */
export type EchoOutcome = "hit" | "no_echo";

/**
 * The outline of a cone.
 */
export type Outline = {
/**
 * The sensor.
 */
sensor: CellPoint,
/**
 * Both ends of the axis.
 */
axis: [CellPoint, CellPoint],
/**
 * Polylines.
 */
lines: Array<Array<CellPoint>>, };

/**
 * What features made of a reading.
 */
export type FeatureCase = {
/**
 * The case.
 */
name: FeatureCaseName,
/**
 * What it means.
 */
about: string,
/**
 * What each feature contributed.
 */
parts: Array<FeaturePart>,
/**
 * What the Bayesian update contributed.
 */
routine: RoutinePart | null, };

/**
 * The case of a reading.
 */
export type FeatureCaseName = "associated" | "outlier" | "behind" | "routine";

/**
 * The contribution of a feature.
 */
export type FeaturePart = {
/**
 * The kind of the feature.
 */
feature: FeatureKind,
/**
 * Its weight, 0 to 1.
 */
weight: number,
/**
 * The polygon that it frees.
 */
free: Array<CellPoint> | null,
/**
 * The line segments that it occupies.
 */
occupied: Array<[CellPoint, CellPoint]>, };

/**
 * The kind of a feature.
 */
export type FeatureKind = "wall" | "corner" | "point";

/**
 * The contribution of the Bayesian update.
 */
export type RoutinePart = {
/**
 * Its weight, 0 to 1.
 */
weight: number,
/**
 * The polygon that it frees.
 */
free: Array<CellPoint> | null,
/**
 * The polygon of its arc.
 */
arc: Array<CellPoint> | null,
/**
 * Whether it occupies the arc.
 */
occupies: boolean, };

/**
 * A scan.
 */
export type CurrentScan = {
/**
 * Which item, from 1.
 */
number: number,
/**
 * Its last line of the log.
 */
line: number,
/**
 * Which scan, from 0.
 */
scan: number,
/**
 * A scan has no time of its own: always `null`.
 */
t: number | null,
/**
 * The robot's pose.
 */
robot: WorldPose,
/**
 * The robot.
 */
robot_cell: CellPoint,
/**
 * Its beams.
 */
beams: Array<Beam>, };

/**
 * A beam of a scan.
 */
export type Beam = {
/**
 * Its line of the log.
 */
line: number,
/**
 * The sensor's pose.
 */
pose: WorldPose,
/**
 * Its range, metres; `null`: nothing came back.
 */
range: number | null,
/**
 * The label of what it hit, from 1; `null`: none.
 */
label: number | null,
/**
 * From the sensor to the hit, or as far as the sensor hears.
 */
ray: [CellPoint, CellPoint], };

/**
 * `api/cell`: a cell's state in every source.
 */
export type Cell = {
/**
 * Column.
 */
column: number,
/**
 * Row, from the bottom.
 */
row: number,
/**
 * World x of its centre, metres.
 */
x: number,
/**
 * World y of its centre, metres.
 */
y: number,
/**
 * Its state in each source.
 */
sources: Array<CellSource>, };

/**
 * A cell's state in a source.
 */
export type CellSource = {
/**
 * The source.
 */
name: string,
/**
 * Whether a reading reached it.
 */
touched: boolean,
/**
 * Its class.
 */
class: CellClass,
/**
 * Of a log: updates from interiors of cones.
 */
interior?: number,
/**
 * Of a log: updates from arcs of cones.
 */
arc?: number,
/**
 * Its layers by name.
 */
values: Array<NamedValue>,
/**
 * Of a counting sensor model: the beams that the cell counts.
 */
chosen?: Array<ChosenBeam>, };

/**
 * A name and its value; `null`: it has none.
 */
export type NamedValue = [string, number | null];

/**
 * A cell's class.
 */
export type CellClass = "occupied" | "empty" | "unknown";

/**
 * A beam that a cell of a counting sensor model counts.
 */
export type ChosenBeam = {
/**
 * Its scan, from 0.
 */
scan: number,
/**
 * Which beam of the scan, from 0.
 */
beam: number,
/**
 * What each class gained, "free" last.
 */
gained: Array<[string, number | null]>,
/**
 * Its line of the log.
 */
line: number,
/**
 * The sensor's pose.
 */
pose: WorldPose,
/**
 * Its range, metres; `null`: nothing came back.
 */
range: number | null,
/**
 * The label of what it hit, from 1; `null`: none.
 */
label: number | null,
/**
 * From the sensor to the hit, or as far as the sensor hears.
 */
ray: [CellPoint, CellPoint], };

/**
 * `api/history`: the readings that touched a cell.
 */
export type History = {
/**
 * How many touched it.
 */
total: number,
/**
 * Names of the values in `before` and `after`.
 */
layers: Array<string>,
/**
 * The last of them, latest first.
 */
events: Array<HistoryEvent>,
/**
 * How to read the list, where that needs an explanation.
 */
note: string | null, };

/**
 * A reading that touched a cell.
 */
export type HistoryEvent = {
/**
 * Which item, from 1.
 */
number: number,
/**
 * Its line of the log.
 */
line: number,
/**
 * The log's number of its scan; of a counting sensor model's scan its own, from 0.
 */
scan: number,
/**
 * Its time, seconds.
 */
t: number | null,
/**
 * Its sensor.
 */
sensor: string,
/**
 * Hit or no echo.
 */
outcome: EchoOutcome,
/**
 * Its range, metres.
 */
range: number | null,
/**
 * Where in its cone the cell lay.
 */
region: Region,
/**
 * Its own evidence of the cell; `null` where the method has none.
 */
own: number | null,
/**
 * The cell's values before it.
 */
before: Array<number | null>,
/**
 * The cell's values after it.
 */
after: Array<number | null>, };

/**
 * A region of a cone.
 */
export type Region = "interior" | "arc";

/**
 * `api/working`: what the last item says of each cell that it changed. The lists have an entry a cell.
 */
export type Working = {
/**
 * The lane's position.
 */
position: number,
/**
 * Cells in the interior.
 */
interior: number,
/**
 * Cells on the arc.
 */
arc: number,
/**
 * n, the reading's arc cells, where the method uses it.
 */
n: number | null,
/**
 * The sum of the cancelled evidence over the arc, where the method uses it.
 */
sum: number | null,
/**
 * What `own` means.
 */
own_is: string,
/**
 * Names of the lists in `before` and `after`.
 */
layers: Array<string>,
/**
 * The steps that the method has.
 */
steps: Array<WorkingStep>,
/**
 * Whether the lists leave cells out, as there are too many.
 */
truncated: boolean,
/**
 * Columns.
 */
column: Array<number>,
/**
 * Rows.
 */
row: Array<number>,
/**
 * 0 interior, 1 arc.
 */
region: Array<number>,
/**
 * Distances from the sensor, metres.
 */
d: Array<number | null>,
/**
 * Angles off the axis, radians.
 */
theta: Array<number | null>,
/**
 * The item's own evidence.
 */
own: Array<number | null>,
/**
 * The evidence after cancellation; `null` in the interior.
 */
cancelled?: Array<number | null>,
/**
 * The evidence after normalisation; `null` in the interior.
 */
normalised?: Array<number | null>,
/**
 * How strong the cell's shade is, 0 to 1.
 */
strength: Array<number | null>,
/**
 * The value whose shade is 1.
 */
strongest: number | null,
/**
 * What `strength` is computed from.
 */
strength_is: string,
/**
 * The cells' layers before the item, a list a layer.
 */
before: Array<Array<number | null>>,
/**
 * The cells' layers after it.
 */
after: Array<Array<number | null>>, };

/**
 * A step of the evidence's computation.
 */
export type WorkingStep = "own" | "cancelled" | "normalised";

/**
 * `api/go`: either `by` and `count`, or `to`.
 */
export type GoRequest = {
/**
 * What is counted.
 */
by?: StepUnit,
/**
 * How many, 1 if left out; negative: back.
 */
count?: number,
/**
 * A position, in items of the first lane.
 */
to?: number,
/**
 * Milliseconds after which the server stops; none: it goes all the way.
 */
budget_ms?: number,
/**
 * The version that the page shows: where the server's is another, all tiles count as changed.
 */
since?: number, };

/**
 * What a step is.
 */
export type StepUnit = "reading" | "scan";

/**
 * `api/lanes`: the lanes that are to be made, one or two.
 */
export type LanesRequest = {
/**
 * The lanes.
 */
lanes: Array<LaneSpec>, };

/**
 * A lane as it is asked for: a method, and the parameters that are set of it and of the sensors.
 */
export type LaneSpec = {
/**
 * The method's name.
 */
method: string,
/**
 * Keys and values, as in `--set`.
 */
set: { [key in string]: string }, };

/**
 * `api/gpu/plan`: the steps that the page dispatches for each batch.
 */
export type GpuPlan = {
/**
 * Whether the page can map by this method.
 */
supported: boolean,
/**
 * Why it can't.
 */
why: string | null,
/**
 * 32-bit words of a tile of 16 × 16 cells.
 */
tile_words: number,
/**
 * Tiles of a chunk.
 */
chunk_tiles: number,
/**
 * The steps in order.
 */
steps: Array<GpuStep>, };

/**
 * A step: a kernel with its mode, or the host's share computation.
 */
export type GpuStep = {
/**
 * The kernel to dispatch.
 */
kernel?: string,
/**
 * The mode to write into the frame first.
 */
mode?: number,
/**
 * The server turns the counts of arc cells into shares.
 */
share?: boolean, };

/**
 * Bytes of a batch, counted from its first buffer.
 */
export type GpuSpan = {
/**
 * The first byte.
 */
at: number,
/**
 * How many.
 */
bytes: number, };

/**
 * A named buffer of a batch.
 */
export type GpuBuffer = {
/**
 * Its name.
 */
name: string,
/**
 * The first byte.
 */
at: number,
/**
 * How many.
 */
bytes: number, };

/**
 * A shader of a batch.
 */
export type GpuShader = {
/**
 * The request that gives its WGSL.
 */
path: string,
/**
 * Its entry point.
 */
entry: string,
/**
 * Its pipeline constants.
 */
constants: { [key in string]: number }, };

/**
 * A chunk that a batch changes.
 */
export type GpuChunk = {
/**
 * Its column and row.
 */
place: [number, number],
/**
 * Its tiles.
 */
tiles: GpuSpan,
/**
 * The tiles' lists of readings.
 */
entries: GpuSpan,
/**
 * How many tiles: a workgroup each.
 */
count: number,
/**
 * The tiles' slots in the chunk.
 */
slots: Array<number>, };

/**
 * `api/gpu/batch`: the JSON head of a batch.
 */
export type GpuBatch = {
/**
 * The first item.
 */
from: number,
/**
 * The item behind the last.
 */
to: number,
/**
 * The uniform.
 */
frame: GpuSpan,
/**
 * Readings in the batch.
 */
readings: number,
/**
 * Bytes of the buffer for partial sums.
 */
parts_bytes: number,
/**
 * Shaders by kernel.
 */
shaders: { [key in string]: GpuShader },
/**
 * Buffers, in the order of their bindings.
 */
buffers: Array<GpuBuffer>,
/**
 * Chunks.
 */
chunks: Array<GpuChunk>, };

/**
 * `api/gpu/words`: the page's cells compared with the server's.
 */
export type GpuCheck = {
/**
 * Tiles compared.
 */
tiles: number,
/**
 * Cells compared.
 */
cells: number,
/**
 * Cells that other readings reach.
 */
membership_differences: number,
/**
 * Cells with other values.
 */
value_differences: number,
/**
 * The largest difference of a value.
 */
largest: number | null, };
