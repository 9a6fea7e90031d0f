import type { ServerText, Service } from "./frames";
import { textOf, writeServiceRequest } from "./frames";

interface Pending {
  resolve: (value: unknown) => void;
  reject: (error: Error) => void;
}

/** A failed call; its message is the server's one sentence. */
export class CallError extends Error {}

/** The services of the server, called by name; each call is a promise. Calls are never queued over a lost link. */
export class Calls {
  private readonly services = new Map<string, number>();
  private readonly pending = new Map<number, Pending>();
  private nextId = 1;
  /** What was asked for since the link opened, until the server says what it offers; null: it did. */
  private early: (() => void)[] | null = null;

  constructor(private readonly send: (data: Uint8Array) => boolean) {}

  opened(): void {
    this.early = [];
  }

  advertised(services: Service[]): void {
    for (const service of services) this.services.set(service.name, service.id);
    this.callEarly();
  }

  withdrawn(ids: number[]): void {
    for (const [name, id] of this.services) if (ids.includes(id)) this.services.delete(name);
  }

  call(name: string, request: object): Promise<unknown> {
    const { early } = this;
    if (early)
      return new Promise((resolve, reject) => {
        early.push(() => void this.call(name, request).then(resolve, reject));
      });
    const service = this.services.get(name);
    if (service === undefined) return Promise.reject(new CallError(`The server has no service '${name}'.`));
    const callId = this.nextId++;
    return new Promise((resolve, reject) => {
      this.pending.set(callId, { resolve, reject });
      if (!this.send(writeServiceRequest(service, callId, request))) this.lost();
    });
  }

  answered(callId: number, data: DataView): void {
    const body = textOf(data);
    this.take(callId)?.resolve(body === "" ? {} : JSON.parse(body));
  }

  failed(failure: Extract<ServerText, { op: "serviceCallFailure" }>): void {
    this.take(failure.callId)?.reject(new CallError(failure.message));
  }

  lost(): void {
    this.services.clear();
    for (const { reject } of this.pending.values()) reject(new CallError("The connection was lost."));
    this.pending.clear();
    this.callEarly();
  }

  private callEarly(): void {
    const { early } = this;
    this.early = null;
    for (const call of early ?? []) call();
  }

  private take(callId: number): Pending | undefined {
    const pending = this.pending.get(callId);
    this.pending.delete(callId);
    return pending;
  }
}
