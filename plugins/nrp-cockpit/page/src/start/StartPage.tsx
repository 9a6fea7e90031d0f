import { type ReactNode, useState } from "react";
import { Notices } from "../shell/Notices";
import { Rail } from "../shell/Rail";
import { LinkState } from "../shell/StatusBar";
import { notify } from "../state/notices";
import { type Entry, look, open, useStart } from "../state/start";
import { Button, IconButton } from "../ui/Button";
import { counted } from "../ui/counts";
import { Empty } from "../ui/Panel";
import { familiesOf, partsOf, type Section, sectionsOf } from "./entries";
import { usePicture } from "./pictures";
import "../shell/shell.css";
import "../toolbar/toolbar.css";
import "./start.css";

/** The start page: what can be opened, to be searched by words. */
export default function StartPage() {
  const start = useStart((state) => state.start);
  const opening = useStart((state) => state.opening);
  const [search, setSearch] = useState("");
  const sections = start?.entries ? sectionsOf(start.entries, search) : [];
  return (
    <div className="app">
      <a className="skip" href="#main">
        Skip to content
      </a>
      <Rail views={[]} />
      <header className="bar">
        <h1 className="bar-name">Open a run</h1>
        <input
          className="input start-search"
          type="search"
          aria-label="Search"
          placeholder="Search"
          value={search}
          onChange={(event) => setSearch(event.target.value)}
        />
        <IconButton icon="reset" label="Look again" kind="ghost" onClick={() => void look()} />
        <span className="grow" />
        <span className="mut f12 cut mono wide">{start?.folder}</span>
      </header>
      <main id="main" className="main start" tabIndex={-1} aria-busy={opening !== null}>
        {!start && <Empty>Waiting for the experiments.</Empty>}
        {sections.map((section) => (
          <Entries key={section.title} section={section} />
        ))}
        {start && sections.length === 0 && <Empty>Nothing has these words.</Empty>}
      </main>
      <footer className="status">
        <LinkState />
        {opening && <span role="status">Opening {opening}</span>}
      </footer>
      <Notices />
    </div>
  );
}

function Entries({ section: { title, entries, none } }: { section: Section }) {
  return (
    <section aria-label={title}>
      <h2>{title}</h2>
      <Consent entries={entries} />
      {entries.length === 0 && <p className="mut">{none}</p>}
      <ul className="start-entries">
        {familiesOf(entries).map(({ entry, variants }) => (
          <li key={entry.name}>
            <Card entry={entry} />
            {variants.length > 0 && <Variants entries={variants} />}
          </li>
        ))}
      </ul>
    </section>
  );
}

/** Draws the experiments in the folder when the user has agreed that their files are read. */
function Consent({ entries }: { entries: Entry[] }) {
  const readsFiles = useStart((state) => state.readsFiles);
  if (readsFiles || !entries.some(({ installed, picture }) => !installed && picture)) return null;
  return (
    <p className="row mut start-consent">
      <Button small onClick={() => useStart.setState({ readsFiles: true })}>
        Draw their scenes
      </Button>
      This reads their robots, rooms and images, and executes nothing.
    </p>
  );
}

function Variants({ entries }: { entries: readonly Entry[] }) {
  return (
    <details className="start-variants">
      <summary>{counted(entries.length, "variant")}</summary>
      {entries.map((entry) => (
        <Opener key={entry.name} entry={entry} className="start-variant">
          <b>{partsOf(entry).variant}</b>{" "}
          <span className={entry.error ? "bad-t" : "mut"}>{entry.error || entry.text}</span>
        </Opener>
      ))}
    </details>
  );
}

/** A button that opens an entry, or says why it does not. */
function Opener({ entry, className, children }: { entry: Entry; className: string; children: ReactNode }) {
  const opening = useStart((state) => state.opening);
  const refused = entry.error || (opening && `${opening} is being opened.`);
  return (
    <button
      type="button"
      className={className}
      aria-label={`Open ${entry.name}`}
      aria-disabled={refused ? true : undefined}
      aria-busy={opening === entry.name || undefined}
      onClick={() => (refused ? notify(refused) : void open(entry.name))}
    >
      {children}
    </button>
  );
}

function Card({ entry }: { entry: Entry }) {
  const { name, variant } = partsOf(entry);
  return (
    <Opener entry={entry} className="panel start-card">
      {entry.kind === "experiment" && <Picture entry={entry} />}
      <b>
        {name}
        {variant && <span className="mut"> / {variant}</span>}
      </b>
      <span className={entry.error ? "bad-t" : "mut"}>{entry.error || entry.text}</span>
      <span className="row tight">
        {entry.engines.map((engine) => (
          <span key={engine} className="tag">
            {engine}
          </span>
        ))}
      </span>
    </Opener>
  );
}

/** The picture of an experiment; until it comes, the room that it takes. */
function Picture({ entry }: { entry: Entry }) {
  const address = usePicture(entry);
  return (
    <span className="start-picture" aria-busy={address === undefined || undefined}>
      {address && <img src={address} alt={`The scene of ${entry.name}`} />}
    </span>
  );
}
