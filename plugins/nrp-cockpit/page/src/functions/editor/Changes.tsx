import { MergeView } from "@codemirror/merge";
import { EditorState } from "@codemirror/state";
import { useEffect, useRef } from "react";
import type { SourceFile } from "../../state/types";
import { showing } from "./extensions";

/** What runs at the left, what is edited at the right. */
export function Changes({ file, text }: { file: SourceFile; text: string }) {
  const host = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const extensions = [showing(file), EditorState.readOnly.of(true)];
    const view = new MergeView({
      parent: host.current as HTMLElement,
      a: { doc: file.source, extensions },
      b: { doc: text, extensions },
      collapseUnchanged: { margin: 3, minSize: 6 },
    });
    return () => view.destroy();
  }, [file, text]);
  return (
    <div className="changes">
      <div className="changes-names f11 mut" aria-hidden="true">
        <span>Running</span>
        <span>Edited</span>
      </div>
      {/* biome-ignore lint/a11y/noNoninteractiveTabindex: it scrolls, so the keyboard must reach it */}
      <section ref={host} className="changes-body scroll" tabIndex={0} aria-label="Running and edited text" />
    </div>
  );
}
