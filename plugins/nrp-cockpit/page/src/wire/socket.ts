import { SUBPROTOCOLS } from "./frames";

export type Link =
  | { state: "connecting" }
  | { state: "open" }
  /** Lost; the next attempt comes after this many seconds. */
  | { state: "lost"; retry_s: number }
  /** The server does not let this page in, and says why. */
  | { state: "refused"; reason: string };

export interface Listener {
  onLink: (link: Link) => void;
  onData: (data: string | ArrayBuffer) => void;
}

/** The other end of the wire: a server, or a recording in the page itself. */
export interface Source {
  open(): void;
  close(): void;
  /** Sends a message; false: there is no connection. */
  send(data: string | Uint8Array): boolean;
}

const WAITS_S = [1, 2, 3, 5];

/** The code with which the server closes a connection because it shows something else from now on. */
const ANOTHER_RUN = 1012;

/** Forgets all that the page knows, and which view was open. */
function beginAnew(): void {
  window.location.hash = "";
  window.location.reload();
}

/** The socket's address: beside the page, with the page's own token and the run that it shows. */
export function addressOf(page: Location): string {
  const url = new URL("ws", page.href.replace(/[?#].*/, ""));
  url.protocol = page.protocol === "https:" ? "wss:" : "ws:";
  const given = new URLSearchParams(page.search);
  url.search = new URLSearchParams({
    token: given.get("token") ?? "",
    run: given.get("run") ?? "",
    embedded: String(given.has("embedded")),
  }).toString();
  return url.href;
}

/** A WebSocket that opens again after it was lost, and counts down to the next attempt. */
export class Socket implements Source {
  private socket: WebSocket | null = null;
  private timer = 0;
  private attempt = 0;

  constructor(
    private readonly address: string,
    private readonly listener: Listener,
  ) {}

  open(): void {
    const socket = new WebSocket(this.address, SUBPROTOCOLS);
    let opened = false;
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.listener.onLink({ state: "connecting" });
    socket.onopen = () => {
      opened = true;
      this.attempt = 0;
      this.listener.onLink({ state: "open" });
    };
    socket.onmessage = ({ data }) => this.listener.onData(data);
    socket.onclose = async ({ code }) => {
      if (code === ANOTHER_RUN) {
        beginAnew();
        return;
      }
      const reason = opened ? null : await this.refusal();
      if (this.socket !== socket) return;
      if (reason) this.listener.onLink({ state: "refused", reason });
      else this.countDown(WAITS_S[Math.min(this.attempt++, WAITS_S.length - 1)] ?? 5);
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

  /** Why the server refuses this page, if it does; a browser does not say that of a socket. */
  private async refusal(): Promise<string | null> {
    try {
      const answer = await fetch(this.address.replace(/^ws/, "http"));
      return answer.status === 401 ? (await answer.text()).trim() : null;
    } catch {
      return null;
    }
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
