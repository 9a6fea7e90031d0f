/** What the colours of wires and ends mean. */
export const Legend = () => (
  <p className="legend" aria-hidden="true">
    <span>
      <i className="end-message" /> message
    </span>
    <span>
      <i className="end-drives" /> drives neurons
    </span>
    <span>
      <i className="end-reads" /> reads neurons
    </span>
    <span>
      <i className="end-free" /> free
    </span>
  </p>
);
