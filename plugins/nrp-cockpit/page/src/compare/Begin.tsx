import { useId, useState } from "react";
import { branch, compare, compareRecording } from "../state/commands";
import { useBlocked, useMissing, useRun } from "../state/run";
import { Button } from "../ui/Button";

/** What the view offers while there is one run: another future, or other engines. */
export function Begin() {
  const recording = useRun(({ experiment }) => (experiment?.source === "recording" ? experiment.file : null));
  if (recording !== null)
    return (
      <div className="compare-begin">
        <Recorded folder={recording} />
        <OtherRecording />
      </div>
    );
  return (
    <div className="compare-begin">
      <NewBranch />
      <OtherEngines />
    </div>
  );
}

/** A recording has no second future of its own. */
function Recorded({ folder }: { folder: string }) {
  const t_s = useRun((run) => run.status?.t_s ?? 0);
  return (
    <section className="panel" aria-label="Branch">
      <div className="panel-head">
        <h2>Another future</h2>
      </div>
      <div className="panel-body compare-card">
        <p>Only a run can be branched. This command continues the recording as a run from this moment:</p>
        <p>
          <code>
            nrp replay {folder} --from {t_s.toFixed(2)}s
          </code>
        </p>
      </div>
    </section>
  );
}

const NO_NEIGHBOURS: readonly string[] = [];

function OtherRecording() {
  const blocked = useBlocked();
  const neighbours = useRun((run) => run.experiment?.neighbours ?? NO_NEIGHBOURS);
  const [chosen, setChosen] = useState("");
  const recording = chosen || (neighbours[0] ?? "");
  const none = neighbours.length === 0 ? "There is no other recording in the folder of this one." : undefined;
  return (
    <section className="panel" aria-label="Comparison">
      <div className="panel-head">
        <h2>Another recording</h2>
      </div>
      <div className="panel-body compare-card">
        <p>A second recording from the same folder is shown beside this one, at the same time.</p>
        <div className="compare-choices">
          <Choice label="Recording" of={neighbours} value={recording} onChange={setChosen} />
        </div>
        <Button
          kind="primary"
          icon="compare"
          disabled={blocked ?? none}
          onClick={() => void compareRecording(recording)}
        >
          Compare
        </Button>
      </div>
    </section>
  );
}

function NewBranch() {
  const blocked = useBlocked();
  const missing = useMissing("snapshot");
  const t_s = useRun((run) => run.status?.t_s ?? 0);
  const snapshots = useRun((run) => run.timeline?.snapshots);
  return (
    <section className="panel" aria-label="Branch">
      <div className="panel-head">
        <h2>Another future</h2>
      </div>
      <div className="panel-body compare-card">
        <p>
          A second run continues from this moment, in step with the first. Change one of them to see how they
          differ.
        </p>
        <p className="mut">To branch earlier, go back to that time first.</p>
        <Button
          kind="primary"
          icon="branch"
          disabled={blocked ?? missing}
          onClick={() => void branch({ t_s: null })}
        >
          Branch at {t_s.toFixed(2)} s
        </Button>
        {snapshots?.map(({ id, t_s: taken_s, left }) => (
          <Button
            key={id}
            small
            icon={left ? "branch" : "snapshot"}
            disabled={blocked ?? missing}
            onClick={() => void branch({ id })}
          >
            Branch at {left ? "the end of the abandoned future" : "the snapshot"}, {taken_s.toFixed(2)} s
          </Button>
        ))}
      </div>
    </section>
  );
}

function OtherEngines() {
  const blocked = useBlocked();
  const experiment = useRun((run) => run.experiment);
  const [brain, setBrain] = useState("");
  const [world, setWorld] = useState("");
  if (!experiment?.backends) return null;
  const same =
    (brain || experiment.brain) === experiment.brain && (world || experiment.world) === experiment.world;
  return (
    <section className="panel" aria-label="Comparison">
      <div className="panel-head">
        <h2>Other engines</h2>
      </div>
      <div className="panel-body compare-card">
        <p>The same experiment begins again on two pairs of engines, in step, with the same seed.</p>
        <div className="compare-choices">
          <Choice
            label="Brain"
            of={experiment.backends.brain}
            value={brain || experiment.brain}
            onChange={setBrain}
          />
          <Choice
            label="World"
            of={experiment.backends.world}
            value={world || experiment.world}
            onChange={setWorld}
          />
        </div>
        <Button
          kind="primary"
          icon="compare"
          disabled={blocked ?? (same ? "Choose another brain or another world." : undefined)}
          onClick={() => void compare(brain || null, world || null)}
        >
          Compare from 0 s
        </Button>
      </div>
    </section>
  );
}

interface ChoiceProps {
  label: string;
  of: readonly string[];
  value: string;
  onChange: (value: string) => void;
}

function Choice({ label, of, value, onChange }: ChoiceProps) {
  const id = useId();
  return (
    <div className="field">
      <label htmlFor={id}>{label}</label>
      <select id={id} className="input" value={value} onChange={(event) => onChange(event.target.value)}>
        {of.map((name) => (
          <option key={name}>{name}</option>
        ))}
      </select>
    </div>
  );
}
