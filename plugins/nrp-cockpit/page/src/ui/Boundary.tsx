import { Component, type ReactNode } from "react";
import { Button } from "./Button";
import { Empty, Panel } from "./Panel";

interface BoundaryProps {
  /** The title of the panel that shows the error. */
  title: string;
  children: ReactNode;
}

/** Shows an error in the place of what it holds, so that all around it stays. */
export class Boundary extends Component<BoundaryProps, { error: Error | null }> {
  override state = { error: null as Error | null };

  static getDerivedStateFromError(error: unknown) {
    return { error: error instanceof Error ? error : new Error(String(error)) };
  }

  override render() {
    const { error } = this.state;
    if (!error) return this.props.children;
    const again = <Button onClick={() => this.setState({ error: null })}>Try again</Button>;
    return (
      <Panel title={this.props.title}>
        <div role="alert" className="wide-note">
          <Empty action={again}>This cannot be shown because of an error of the page: {error.message}</Empty>
        </div>
      </Panel>
    );
  }
}
