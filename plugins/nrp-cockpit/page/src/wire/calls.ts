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

  constructor(private readonly send: (data: Uint8Array) => boolean) {}

  advertised(services: Service[]): void {
    for (const service of services) this.services.set(service.name, service.id);
  }

  withdrawn(ids: number[]): void {
    for (const [name, id] of this.services) if (ids.includes(id)) this.services.delete(name);
  }

  call(name: string, request: object): Promise<unknown> {
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
  }

  private take(callId: number): Pending | undefined {
    const pending = this.pending.get(callId);
    this.pending.delete(callId);
    return pending;
  }
}
