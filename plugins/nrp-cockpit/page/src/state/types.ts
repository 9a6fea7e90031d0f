/** What the server says about a run, as JSON on its `/cockpit/` topics. */

export type Vector = [number, number, number];

export interface TopicInfo {
  name: string;
  type: string;
  /** "in": the run hears it; "out": the run sends it. */
  direction: "in" | "out";
  unit: string | null;
  /** The names of the items of its arrays, in their order. */
  elements: string[];
  rate_hz: number | null;
}

export interface Population {
  label: string;
  size: number;
  /** The number of its first neuron in the brain's own counting. */
  first: number;
  cell: string;
  role: "sensor" | "actor" | "circuit";
  /** null: it has none, or there are too many to list. */
  positions: Vector[] | null;
  /** Whether its cells have positions. */
  placed: boolean;
  /** Whether no cell of it fires in all of a recording. */
  silent?: boolean;
}

/** Cells with a name of their own. */
export interface CellGroup {
  name: string;
  /** Half-open ranges of their numbers in each population. */
  cells: Ranges;
  /** The cells that are drawn as the group's: one in several groups belongs to the smallest. */
  own: Ranges;
}

type Ranges = Record<string, [from: number, to: number][]>;

export interface Projection {
  id: string;
  label: string;
  pre: string;
  post: string;
  receptor: string;
  synapse: string;
  size: number;
  excites: boolean;
  /** [from, to, weight]; null when there are too many to draw. */
  edges: [number, number, number][] | null;
}

export interface Device {
  name: string;
  topic: string;
  population: string;
  neurons: number[];
  kind: string;
  unit: string;
}

export interface Body {
  name: string;
  static: boolean;
  /** Where it is, if it never moves by itself; null otherwise, and in recordings. */
  pose: { position: Vector; orientation: [number, number, number, number] } | null;
  topics: string[];
  /** The topic that colours it, if one does. */
  colorable: string | null;
  /** The part that gets that colour, as the id of its entity in the scene. */
  colored_part: string | null;
}

/** How a camera or a laser scanner is mounted; it looks along x, with z up. */
export interface Mount {
  topic: string;
  /** The frame that it moves with, and its pose in that. */
  frame: string;
  position: Vector;
  orientation: [number, number, number, number];
  /** What a camera sees, horizontally and as width over height; null: it is a laser scanner. */
  view: { fov_rad: number; aspect: number } | null;
}

/** A light of the room that is on. */
export interface Light {
  kind: "directional" | "point" | "spot";
  position: Vector;
  direction: Vector;
  color: Vector;
  casts_shadows: boolean;
  /** null: it has no end. */
  range_m: number | null;
  /** At a distance d the light is divided by the first + second * d + third * d^2. */
  attenuation: Vector;
  /** The full angle of any light of a spot. */
  cone_rad: number;
}

export interface Experiment {
  name: string;
  file: string;
  brain: string;
  world: string;
  seed: number;
  duration_s: number | null;
  timestep_s: number;
  source: "live" | "recording";
  may_steer: boolean;
  /** Each: true, or the reason why not. */
  capabilities: Record<string, true | string>;
  /** The names of the other recordings in the folder of a recording. */
  neighbours?: string[];
  /** What can be chosen for another run; null: a recording. */
  backends: { brain: string[]; world: string[] } | null;
  topics: TopicInfo[];
  robots: string[];
  populations: Population[];
  groups: CellGroup[];
  projections: Projection[];
  devices: Device[];
  bodies: Body[];
  mounts: Mount[];
  lights: Light[];
}

export interface Status {
  state: "paused" | "running" | "finished" | "failed" | "busy";
  /** What a busy run does. */
  doing: string | null;
  t_s: number;
  wall_s: number;
  /** null: time does not go on, or nobody measured how fast. */
  real_time_factor: number | null;
  /** Simulated seconds a wall second at most; null: as fast as it can. */
  pace: number | null;
  recording: { path: string; bytes: number } | null;
  /** The folder of the last finished recording, which can be saved as one HTML file. */
  recorded: string | null;
  /** How many pages look at the run, and how many of them can control it. */
  viewers: number;
  controllers: number;
  dropped: number;
  /** null, as the shares: there was no step yet. */
  server_ms_per_step: number | null;
  share: { brain: number; world: number; functions: number; loop: number } | null;
  error: { message: string; file: string | null; line: number | null } | null;
  passed: boolean | null;
  complete: boolean;
}

export interface TransferFunction {
  name: string;
  file: string;
  line: number;
  flow: string;
  active: boolean;
  /** `stops`: it ended the run; otherwise the run goes on without the function. */
  failure: { t_s: number; message: string; traceback: string; stops: boolean } | null;
  calls: number;
  /** Since when calls are counted: 0, or when the run went to another time. */
  since_s: number;
  mean_ms: number;
  recent_ms: number[];
}

export interface SourceFile {
  path: string;
  source: string;
  language: "python" | "bibi";
  editable: boolean;
}

export interface Functions {
  functions: TransferFunction[];
  files: SourceFile[];
}

export interface TimelineData {
  duration_s: number | null;
  events: { name: string; t_s: number | null; waits_for: string }[];
  /** Changes of the brain during the run, past and future. */
  interventions: { name: string; t_s: number }[];
  criteria: {
    name: string;
    passed: boolean | null;
    from_s: number;
    to_s: number;
    text: string;
    /** What it measures, if that is a number of a topic, and its limits. */
    curve?: { topic: string; path: string; limits: number[] } | null;
  }[];
  failures: { t_s: number; function: string; message: string }[];
  /** Requested snapshots, and (`left`) the ends of abandoned futures. */
  snapshots: { id: string; t_s: number; left: boolean }[];
  /** The times of automatic snapshots. */
  automatic_s: number[];
  /** Changes of the run from outside. */
  edits: { t_s: number; name: string }[];
}

export interface Finding {
  code: string;
  weight: "error" | "warning" | "note";
  summary: string;
  why: string;
  fix: string;
  file: string | null;
  line: number | null;
  /** Counted from 1. */
  column: number | null;
  count: number;
  /** The name in that line that nothing has, and the one that was probably meant. */
  instead: { written: string; meant: string } | null;
}
