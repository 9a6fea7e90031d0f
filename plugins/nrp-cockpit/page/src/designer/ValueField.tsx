import { useEffect, useId, useRef, useState } from "react";
import { Switch } from "../ui/Switch";
import { labelOf } from "./model";
import { PythonEditor } from "./PythonEditor";
import { change, named, useDesign } from "./store";
import type { Feature, NodeData } from "./types";

interface ValueProps {
  path: string;
  part: NodeData;
  feature: Feature;
}

const textOf = ({ fields }: NodeData, { field }: Feature): string => {
  const held = fields[field];
  return Array.isArray(held) ? held.join(", ") : typeof held === "string" ? held : "";
};

/** One value: a switch, a choice, or a text that the server checks when one leaves it. */
export function ValueField({ path, part, feature }: ValueProps) {
  const text = textOf(part, feature);
  const [error, setError] = useState<string>();
  // biome-ignore lint/correctness/useExhaustiveDependencies: another value, as by Undo, ends what was wrong
  useEffect(() => setError(undefined), [text]);
  const set = async (value: string) => {
    const reason =
      value === text ? undefined : await change("set", { path, field: feature.field, text: value });
    setError(reason);
    return reason === undefined;
  };
  const id = useId();
  const label = labelOf(feature);
  if (feature.of === "Truth")
    return (
      <div className="field">
        <span>{label}</span>
        <Switch label={label} on={text === "true"} onChange={(on) => void set(String(on))} />
      </div>
    );
  return (
    <div className={feature.of === "Code" ? "field field-wide" : "field"}>
      <label htmlFor={id}>{label}</label>
      <Control id={id} path={path} text={text} feature={feature} error={error} onSet={set} />
      {error && (
        <p id={`${id}-error`} className="field-error" role="alert">
          {error}
        </p>
      )}
    </div>
  );
}

interface ControlProps {
  id: string;
  path: string;
  text: string;
  feature: Feature;
  error: string | undefined;
  /** Resolves to whether the server took it. */
  onSet: (text: string) => Promise<boolean>;
}

function Control({ id, path, text, feature, error, onSet }: ControlProps) {
  const choices = useChoices(feature, text);
  if (choices)
    return (
      <select id={id} className="input" value={text} onChange={(event) => void onSet(event.target.value)}>
        {feature.least === 0 && <option value="">default</option>}
        {choices.map((choice) => (
          <option key={choice}>{choice}</option>
        ))}
      </select>
    );
  if (feature.of === "Code")
    return (
      <PythonEditor
        path={path}
        label={labelOf(feature)}
        text={text}
        whole
        onWrite={(value) => void onSet(value)}
      />
    );
  return <TextInput {...{ id, path, text, feature, error, onSet }} />;
}

/** What a value can be, where that is known: an enumeration, or the populations of the brain. */
function useChoices(feature: Feature, text: string): string[] | null {
  const populations = useDesign(({ state }) => state?.populations);
  if (feature.enumeration.length > 0) return feature.enumeration;
  const isPopulation =
    feature.of === "PopulationName" || (feature.field === "population" && !feature.is_node);
  if (!isPopulation || !populations) return null;
  const names = Object.keys(populations);
  return names.length === 0 ? null : names.includes(text) || text === "" ? names : [text, ...names];
}

/** What can stand for a value in a form where nothing is given. */
const LEFT_OUT: Record<string, string> = { Cells: "all", NamedCells: "any" };

/** The names that a text may be, proposed while one types. */
function useProposed({ of }: Feature): readonly string[] {
  const state = useDesign((design) => design.state);
  if (of === "Topic") return Object.keys(state?.topics ?? {});
  return of === "NamedCells" ? (state?.cells ?? []) : [];
}

/** What is typed stays until the server has taken it, however late the server answers; Escape gives it up. */
function TextInput({ id, path, text, feature, error, onSet }: ControlProps) {
  const [typed, setTyped] = useState<string | null>(null);
  const field = useRef<HTMLInputElement>(null);
  const leave = async () => {
    if (typed !== null && (await onSet(typed))) setTyped((now) => (now === typed ? null : now));
  };
  // biome-ignore lint/correctness/useExhaustiveDependencies: another value replaces what nobody types any more
  useEffect(() => {
    if (document.activeElement !== field.current) setTyped(null);
  }, [text]);
  const proposed = useProposed(feature);
  const giveUp = () => {
    setTyped(null);
    void onSet(text);
  };
  const isNew = useDesign(({ isNew, selected }) => isNew && selected === path && feature.field === "name");
  useEffect(() => {
    if (!isNew) return;
    field.current?.select();
    named();
  }, [isNew]);
  return (
    <span className="form-value">
      <input
        id={id}
        ref={field}
        value={typed ?? text}
        aria-invalid={error ? true : undefined}
        aria-describedby={error ? `${id}-error` : undefined}
        onBlur={() => void leave()}
        className="input"
        placeholder={feature.default || (feature.least ? "" : (LEFT_OUT[feature.of] ?? "default"))}
        title={feature.expects}
        spellCheck={false}
        autoComplete="off"
        list={proposed.length > 0 ? `${id}-proposed` : undefined}
        onChange={(event) => setTyped(event.target.value)}
        onKeyDown={(event) => {
          if (event.key === "Enter") void leave();
          if (event.key !== "Escape" || typed === null) return;
          event.stopPropagation(); // it would also deselect the part
          giveUp();
        }}
      />
      {proposed.length > 0 && (
        <datalist id={`${id}-proposed`}>
          {proposed.map((name) => (
            <option key={name} value={name} />
          ))}
        </datalist>
      )}
      {feature.unit && <span className="form-unit">{feature.unit}</span>}
    </span>
  );
}
