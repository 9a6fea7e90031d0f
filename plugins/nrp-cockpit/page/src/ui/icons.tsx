/** The drawings of the icons on a 16 by 16 grid, stroked in the colour of the text. */
export const paths = {
  cockpit: (
    <>
      <rect x="2" y="2.5" width="12" height="11" rx="1.5" />
      <path d="M9 2.5v11M2 9h7" />
    </>
  ),
  functions: <path d="M5.5 4 2 8l3.5 4M10.5 4 14 8l-3.5 4" />,
  designer: (
    <>
      <rect x="2" y="2.500" width="5" height="4" rx="1" />
      <rect x="9" y="9.500" width="5" height="4" rx="1" />
      <path d="M7 4.500h2.500a2 2 0 0 1 2 2v3" />
    </>
  ),
  up: <path d="m4 10 4-4 4 4" />,
  theme: (
    <>
      <circle cx="8" cy="8" r="5.500" />
      <path d="M8 2.500v11a5.500 5.500 0 0 0 0-11z" fill="currentColor" />
    </>
  ),
  help: (
    <>
      <circle cx="8" cy="8" r="6" />
      <path d="M6.300 6.300a1.800 1.800 0 1 1 2.600 1.600c-.6.3-.9.7-.9 1.300M8 11.300v.1" />
    </>
  ),
  down: <path d="m4 6 4 4 4-4" />,
  brain: (
    <>
      <circle cx="4" cy="5" r="2" />
      <circle cx="12" cy="4" r="2" />
      <circle cx="9" cy="12" r="2" />
      <path d="M6 5l4-.8M5 6.8l3 3.5M11.4 6l-1.6 4" />
    </>
  ),
  world: <path d="M8 2l5.5 3v6L8 14l-5.5-3V5zM2.5 5L8 8l5.5-3M8 8v6" />,
  stepBack: (
    <>
      <path d="M12 3.5v9L6 8z" fill="currentColor" />
      <path d="M3.5 3.5v9" />
    </>
  ),
  play: <path d="M5 3.5v9l7.500-4.500z" fill="currentColor" />,
  pause: <path d="M5.500 3.500v9M10.500 3.500v9" strokeWidth="2.500" />,
  step: (
    <>
      <path d="M4 3.500v9l6-4.500z" fill="currentColor" />
      <path d="M12.500 3.500v9" />
    </>
  ),
  reset: <path d="M3 8a5 5 0 1 0 1.600-3.700M3 2.500v3h3" />,
  target: (
    <>
      <circle cx="8" cy="8" r="5" />
      <path d="M8 1.500v3M8 11.500v3M1.500 8h3M11.500 8h3" />
    </>
  ),
  share: <path d="M8 10V2.500M5 5l3-3 3 3M3 8v5.500h10V8" />,
  record: <circle cx="8" cy="8" r="4.500" fill="currentColor" stroke="none" />,
  viewers: (
    <>
      <circle cx="6" cy="5.500" r="2.200" />
      <path d="M2 13c0-2.500 1.800-4 4-4s4 1.500 4 4M10.500 3.500a2.200 2.200 0 0 1 0 4M11.500 9.300c1.500.5 2.500 1.800 2.500 3.700" />
    </>
  ),
  fit: <path d="M2.500 6V2.500H6M10 2.500h3.500V6M13.500 10v3.500H10M6 13.500H2.500V10" />,
  expand: <path d="M9.500 2.500h4v4M6.500 13.500h-4v-4M13.500 2.500l-5 5M2.500 13.500l5-5" />,
  shrink: <path d="M13.500 6.500h-4v-4M2.500 9.500h4v4M9.500 6.500l4.500-4.500M6.500 9.500l-4.500 4.500" />,
  more: <path d="M3.500 8h.1M8 8h.1M12.500 8h.1" strokeWidth="2.500" />,
  plus: <path d="M8 3v10M3 8h10" />,
  minus: <path d="M3 8h10" />,
  close: <path d="m4 4 8 8M12 4l-8 8" />,
  lock: (
    <>
      <rect x="3.500" y="7" width="9" height="6.500" rx="1" />
      <path d="M5.500 7V5a2.500 2.500 0 0 1 5 0v2" />
    </>
  ),
  check: <path d="m3.500 8.500 3 3 6-7" />,
  plot: <path d="M2.500 2.500v11h11M5 10l2.500-3 2 2L13 5" />,
  push: <path d="M2 8h8M7 5l3 3-3 3M13 3v10" />,
  move: (
    <path d="M8 2v12M2 8h12M8 2 6.500 3.500M8 2l1.500 1.500M8 14l-1.500-1.500M8 14l1.500-1.500M2 8l1.500-1.500M2 8l1.500 1.500M14 8l-1.500-1.500M14 8l-1.500 1.500" />
  ),
  eye: (
    <>
      <path d="M1.500 8S4 3.500 8 3.500 14.500 8 14.500 8 12 12.500 8 12.500 1.500 8 1.500 8z" />
      <circle cx="8" cy="8" r="2" />
    </>
  ),
  snapshot: <path d="M4 2.500h8v11L8 10.500l-4 3z" />,
  branch: (
    <>
      <path d="M4.500 2.500v11M4.500 10c0-4 7-2 7-5.500" />
      <circle cx="11.500" cy="3.500" r="1.500" />
    </>
  ),
  compare: <path d="M2.500 3h4.500v10H2.500zM9 3h4.500v10H9z" />,
  clock: (
    <>
      <circle cx="8" cy="8" r="6" />
      <path d="M8 4.500V8l2.500 1.500" />
    </>
  ),
  error: (
    <>
      <circle cx="8" cy="8" r="6" />
      <path d="m6 6 4 4M10 6l-4 4" />
    </>
  ),
  warning: <path d="M8 2.500 14 13H2zM8 6.500V9.500M8 11.300v.1" />,
  note: (
    <>
      <circle cx="8" cy="8" r="6" />
      <path d="M8 7.500v3.500M8 5v.1" />
    </>
  ),
  undo: <path d="M3 6h6.500a3.500 3.500 0 0 1 0 7H6M3 6l3-3M3 6l3 3" />,
  redo: <path d="M13 6H6.500a3.500 3.500 0 0 0 0 7H10M13 6l-3-3M13 6l-3 3" />,
  arrange: (
    <>
      <rect x="2" y="6" width="4" height="4" />
      <rect x="10" y="2" width="4" height="4" />
      <rect x="10" y="10" width="4" height="4" />
      <path d="M6 8h2V4h2M8 8v4h2" />
    </>
  ),
  save: (
    <>
      <path d="M2.500 2.500h8l3 3v8h-11z" />
      <path d="M5 2.500v3.500h5V2.500M5 13.500V9.500h6v4" />
    </>
  ),
  copy: (
    <>
      <rect x="5.500" y="5.500" width="8" height="8" rx="1" />
      <path d="M10.500 5.500v-3h-8v8h3" />
    </>
  ),
} as const;
