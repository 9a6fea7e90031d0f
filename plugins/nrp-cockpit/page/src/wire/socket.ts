import { SUBPROTOCOLS } from "./frames";

export type Link =
  | { state: "connecting" }
  | { state: "open" }
  /** Lost; the next attempt comes after this many seconds. */
  | { state: "lost"; retry_s: number };

interface Listener {
  onLink: (link: Link) => void;
  onData: (data: string | ArrayBuffer) => void;
}

const WAITS_S = [1, 2, 3, 5];

/** The socket's address: beside the page, with the page's own token and the run that it shows. */
export function addressOf(page: Location): string {
  const url = new URL("ws", page.href.replace(/[?#].*/, ""));
  url.protocol = page.protocol === "https:" ? "wss:" : "ws:";
  const given = new URLSearchParams(page.search);
  url.search = new URLSearchParams({
    token: given.get("token") ?? "",
    run: given.get("run") ?? "",
  }).toString();
  return url.href;
}

/** A WebSocket that opens again after it was lost, and counts down to the next attempt. */
export class Socket {
  private socket: WebSocket | null = null;
  private timer = 0;
  private attempt = 0;

  constructor(
    private readonly address: string,
    private readonly listener: Listener,
  ) {}

  open(): void {
    const socket = new WebSocket(this.address, SUBPROTOCOLS);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.listener.onLink({ state: "connecting" });
    socket.onopen = () => {
      this.attempt = 0;
      this.listener.onLink({ state: "open" });
    };
    socket.onmessage = ({ data }) => this.listener.onData(data);
    socket.onclose = () => {
      if (this.socket === socket) this.countDown(WAITS_S[Math.min(this.attempt++, WAITS_S.length - 1)] ?? 5);
    };
  }

  send(data: string | Uint8Array): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(data as string | Uint8Array<ArrayBuffer>);
    return true;
  }

  close(): void {
    window.clearTimeout(this.timer);
    const socket = this.socket;
    this.socket = null;
    socket?.close();
  }

  private countDown(retry_s: number): void {
    if (retry_s <= 0) {
      this.open();
      return;
    }
    this.listener.onLink({ state: "lost", retry_s });
    this.timer = window.setTimeout(() => this.countDown(retry_s - 1), 1000);
  }
}
