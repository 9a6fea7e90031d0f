import { type ReactNode, useState } from "react";
import { Segmented } from "../ui/Segmented";
import { PythonEditor } from "./PythonEditor";
import { change } from "./store";
import type { Feature, NodeData } from "./types";

const MODES = [
  { value: "text", label: "Text" },
  { value: "blocks", label: "Blocks" },
] as const;

interface ExpressionProps {
  path: string;
  feature: Feature;
  part: NodeData | null;
  /** What is computed, such as the rate of a device, and its unit. */
  title: string;
  unit: string;
  /** The same, block by block. */
  children: ReactNode;
}

/** An expression, as Python or block by block. */
export function ExpressionField({ path, feature, part, title, unit, children }: ExpressionProps) {
  const [mode, setMode] = useState<"text" | "blocks">("text");
  const [error, setError] = useState<string>();
  const write = async (text: string) =>
    setError(
      text === (part?.text ?? "") ? undefined : await change("write", { path, field: feature.field, text }),
    );
  return (
    <div className="form-expression">
      <div className="row">
        <h3>{title}</h3>
        {unit && <span className="dim f11">{unit}</span>}
        <span className="grow" />
        <Segmented label={`${title} as`} choices={MODES} value={mode} onChange={setMode} />
      </div>
      {mode === "text" ? (
        <PythonEditor
          path={path}
          label={`${title} as Python`}
          text={part?.text ?? ""}
          onWrite={(text) => void write(text)}
        />
      ) : (
        children
      )}
      {error && (
        <p className="field-error" role="alert">
          {error}
        </p>
      )}
    </div>
  );
}
