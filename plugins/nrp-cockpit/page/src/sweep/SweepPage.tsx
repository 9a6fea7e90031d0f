import { Notices } from "../shell/Notices";
import { Rail } from "../shell/Rail";
import { LinkState } from "../shell/StatusBar";
import { Empty } from "../ui/Panel";
import { Figure } from "./Figure";
import { Progress } from "./Progress";
import { Runs } from "./Runs";
import { Summary } from "./Summary";
import { useSweep } from "./store";
import "../shell/shell.css";
import "../toolbar/toolbar.css";
import "./sweep.css";

/** The page of a sweep: how far it is, a figure, a line for each combination, and the single runs. */
export default function SweepPage() {
  const sweep = useSweep((state) => state.sweep);
  return (
    <div className="app">
      <a className="skip" href="#main">
        Skip to content
      </a>
      <Rail views={[]} />
      <header className="bar">
        <h1 className="bar-name cut">{sweep?.name ?? "Sweep"}</h1>
        {sweep && <span className="tag">sweep</span>}
        {sweep && (
          <span className="mut f12 cut mono" title={sweep.folder}>
            {sweep.folder.split(/[\\/]/).at(-1)}
          </span>
        )}
      </header>
      <main id="main" className="main" tabIndex={-1}>
        {sweep ? (
          <div className="sweep">
            <Progress sweep={sweep} />
            <Figure sweep={sweep} />
            <Summary sweep={sweep} />
            <Runs sweep={sweep} />
          </div>
        ) : (
          <Empty>Waiting for the sweep.</Empty>
        )}
      </main>
      <footer className="status">
        <LinkState />
      </footer>
      <Notices />
    </div>
  );
}
