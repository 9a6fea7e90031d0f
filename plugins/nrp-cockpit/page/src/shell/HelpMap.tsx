import { useEffect, useRef } from "react";
import { keymap } from "../keys/keymap";
import { useRecorded } from "../state/run";
import { setHelp } from "../state/view";
import { IconButton } from "../ui/Button";
import "./help.css";

/** The notices of the software in the page: beside it on a server, in it in a shared file. */
function Licenses() {
  const inPage = document.getElementById("licenses")?.textContent;
  const title = "Licences of the software in this page";
  return inPage ? (
    <details className="help-licenses">
      <summary>{title}</summary>
      <pre>{inPage}</pre>
    </details>
  ) : (
    <p className="help-licenses">
      <a href="./licenses.md" target="_blank" rel="noreferrer">
        {title}
      </a>
    </p>
  );
}

/** All keys, from the same table that acts on them. */
export function HelpMap() {
  const recorded = useRecorded();
  const entries = keymap.filter(({ changes }) => !(recorded && changes));
  const groups = [...new Set(entries.map(({ group }) => group))];
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => dialog.current?.showModal(), []);
  return (
    <dialog ref={dialog} className="help" aria-label="Keyboard map" onClose={() => setHelp(false)}>
      <div className="panel-head">
        <h2>Keyboard</h2>
        <span className="grow" />
        <IconButton icon="close" label="Close" kind="ghost" small onClick={() => setHelp(false)} />
      </div>
      <div className="help-groups">
        {groups.map((group) => (
          <section key={group} aria-label={group}>
            <h3>{group}</h3>
            <dl>
              {entries
                .filter((entry) => entry.group === group)
                .map(({ shown, does }) => (
                  <div key={shown}>
                    <dt>
                      <kbd>{shown}</kbd>
                    </dt>
                    <dd>{does}</dd>
                  </div>
                ))}
            </dl>
          </section>
        ))}
      </div>
      <Licenses />
    </dialog>
  );
}
