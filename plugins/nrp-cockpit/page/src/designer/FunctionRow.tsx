import { End } from "./End";
import { select, useDesign } from "./store";
import type { Row } from "./types";

const lookOf = (row: Row) => (row.kind === "topic" ? "message" : row.is_written ? "drives" : "reads");

interface RowProps {
  row: Row;
  /** What a click does where the row has no form and its text says the wires. */
  onSelect?: () => void;
}

/** A channel or a variable of a function; a click shows its form. */
export function FunctionRow({ row, onSelect }: RowProps) {
  const selected = useDesign((design) => design.selected === row.path);
  const bad = useDesign(({ findings }) =>
    findings.some(({ path, weight }) => weight === "error" && path.startsWith(row.path)),
  );
  const name = row.name ?? "";
  return (
    <div
      className={`box-row row-${row.kind}`}
      data-end={onSelect ? undefined : row.path}
      data-bad={bad || undefined}
    >
      <button
        type="button"
        className="box-part nodrag"
        aria-pressed={selected}
        aria-label={[row.kind, name, row.type].filter(Boolean).join(" ")}
        onClick={onSelect ?? (() => select(row.path))}
      >
        {row.kind === "local" ? (
          <span className="mono cut box-text">
            {name} = {row.text}
          </span>
        ) : (
          <>
            <span className="box-line">
              <span className="mono cut">{name}</span>
              <span className="box-type">{row.type}</span>
            </span>
            {row.text && <span className="mono cut box-text">{row.text}</span>}
          </>
        )}
      </button>
      {row.kind !== "local" && (
        <End
          id={row.path}
          label={name}
          side={row.kind === "topic" ? "left" : "right"}
          look={lookOf(row)}
          fixed={onSelect !== undefined}
        />
      )}
    </div>
  );
}
