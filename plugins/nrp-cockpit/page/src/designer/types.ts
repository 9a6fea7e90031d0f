/** What the server says about the model that is drawn: its boxes, its wires, its parts, its texts. */

import type { Finding } from "../state/types";

export interface Row {
  /** The end of wires to it: a path in the model, or the neurons that are meant. */
  path: string;
  kind?: "topic" | "local" | "device";
  name?: string;
  type?: string;
  text: string;
  is_written?: boolean;
  neurons?: string;
  /** The name that it has in the run, if it is a device. */
  device?: string;
}

export interface Box {
  id: string;
  kind: "topic" | "function" | "python" | "other" | "population" | "neurons";
  name: string;
  x: number;
  y: number;
  type?: string;
  /** The other file in which it is. */
  file?: string;
  rows?: Row[];
  active?: boolean;
  /** When a function runs, if not every step. */
  when?: string;
  is_sent?: boolean;
  is_heard?: boolean;
  is_used?: boolean;
  is_known?: boolean;
  rate_hz?: number | null;
  size?: number | null;
}

export interface WireData {
  id: string;
  kind: "message" | "drives" | "reads" | "excites" | "inhibits";
  label?: string;
  /** The part of the model that the wire is; without one it belongs to its end inside a function. */
  part?: string;
  source: string;
  source_end: string;
  target: string;
  target_end: string;
}

export interface NodeData {
  type: string;
  line: number;
  /** Expressions and selectors as Python. */
  text: string;
  fields: Record<string, Held>;
}

type One = string | NodeData;
export type Held = One | One[] | null;

export interface DesignState {
  revision: number;
  kind: "functions" | "brain";
  /** Whether the designer wrote it: what a person wrote is shown, and not changed. */
  is_drawn: boolean;
  file: string;
  origin: string | null;
  files: string[];
  is_saved: boolean;
  can_undo: boolean;
  can_redo: boolean;
  notes: string[];
  boxes: Box[];
  wires: WireData[];
  model: NodeData;
  xml: string;
  python: { text: string; lines: number[]; error: string | null };
  populations: Record<string, number>;
  /** Of a brain: its interventions as they stand in an experiment file. */
  interventions?: string;
  /** Of a brain: the names of cells that interventions can mean. */
  cells?: string[];
  /** The message types of all topics, by name. */
  topics: Record<string, string>;
}

export interface Feature {
  field: string;
  name: string;
  /** The type of its value, or the class of its part. */
  of: string;
  is_node: boolean;
  many: boolean;
  least: number;
  unit: string;
  expects: string;
  enumeration: string[];
  default: string;
}

interface ClassData {
  summary: string;
  choices: string[];
  features: Feature[];
}

export interface Metamodel {
  classes: Record<string, ClassData>;
  devices: Record<string, { drives: boolean; property: string; unit: string }>;
}

/** A finding, with the part and the box that it is about. */
export interface PlacedFinding extends Finding {
  path: string;
  box: string;
}
