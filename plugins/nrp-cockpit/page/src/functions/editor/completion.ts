import type { Completion, CompletionContext, CompletionResult } from "@codemirror/autocomplete";
import { syntaxTree } from "@codemirror/language";

const PART = /[\w./]+$/;

/** Offers the names of this experiment (neurons, devices, topics, decorators) for the dotted name at the cursor. */
export const completing =
  (words: () => Promise<readonly Completion[]>) =>
  async (context: CompletionContext): Promise<CompletionResult | null> => {
    const typed = context.matchBefore(PART);
    if (!typed && !context.explicit) return null;
    if (syntaxTree(context.state).resolveInner(context.pos, -1).name === "Comment") return null;
    return { from: typed?.from ?? context.pos, options: await words(), validFor: /^[\w./]*$/ };
  };
