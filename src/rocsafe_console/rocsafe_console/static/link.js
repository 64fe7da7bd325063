// SPDX-License-Identifier: Apache-2.0
// The connection to the server: sections as JSON, vehicles as bytes (picture/frame_bytes.py).
export const STALE_S = 3;
const [OLD_PLACE, OLD_DOSE] = [4, 8];
const HEAD_BYTES = 24;
const VEHICLE_BYTES = 24;
const SILENT_S = 3;
// The code by which a server closes that ends in order.
const GOING = 1001;
const MOST_WAIT_S = 1;
// Of a command that plans; a server that says nothing for longer is gone.
const LONGEST_S = 150;

export function readFrame(buffer) {
  const view = new DataView(buffer);
  if (view.getUint8(0) !== 0x50 || view.getUint8(1) !== 1) throw new Error('not a frame of this version');
  const known = (value, unknown, scale) => (value === unknown ? NaN : value * scale);
  const frame = {
    sequence: view.getUint32(4, true), wall: view.getFloat64(8, true), mission: view.getFloat64(16, true), vehicles: [],
  };
  const count = view.getUint16(2, true);
  for (let at = HEAD_BYTES; at < HEAD_BYTES + count * VEHICLE_BYTES; at += VEHICLE_BYTES) {
    frame.vehicles.push({
      number: view.getUint16(at, true), state: view.getUint8(at + 2), flags: view.getUint8(at + 3),
      latitude: known(view.getInt32(at + 4, true), 0x7fffffff, 1e-7),
      longitude: known(view.getInt32(at + 8, true), 0x7fffffff, 1e-7),
      height: known(view.getInt16(at + 12, true), 0x7fff, 0.1),
      speed: known(view.getUint16(at + 14, true), 0xffff, 0.01),
      battery: known(view.getUint8(at + 16), 0xff, 0.01),
      visited: known(view.getUint8(at + 17), 0xff, 0.01),
      age: known(view.getUint16(at + 18, true), 0xffff, 0.1),
      doseRate: view.getFloat32(at + 20, true),
    });
  }
  return frame;
}

export class Link extends EventTarget {
  constructor() {
    super();
    this.sections = {};
    this.vehicles = new Map();
    this.wall = NaN;
    this.mission = NaN;
    this.heardAt = -Infinity;
    this.offset = 0;
    this.wait = 0.1;
    this.isWanted = false;
    this.hasEnded = false;
    this.isUnranked = false;
  }

  // Seconds since the last word of the server.
  get silence() { return (performance.now() - this.heardAt) / 1000; }
  get isLive() { return this.silence < SILENT_S; }
  // The time of the server now; the clock of this machine may be wrong.
  get now() { return this.wall + (performance.now() - this.heardAt) / 1000; }

  ageOf(vehicle) {
    const age = vehicle.frame?.age;
    return age === undefined || Number.isNaN(age) ? Infinity : age + (performance.now() - vehicle.at) / 1000;
  }

  isStale(vehicle) { return !this.isLive || this.ageOf(vehicle) > STALE_S; }
  // A receiver or a detector may fall silent while the vehicle is heard.
  isPlaceOld(vehicle) { return this.isStale(vehicle) || Boolean(vehicle.frame?.flags & OLD_PLACE); }
  isDoseOld(vehicle) { return this.isStale(vehicle) || Boolean(vehicle.frame?.flags & OLD_DOSE); }

  open() {
    this.isWanted = true;
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    const socket = new WebSocket(`${scheme}://${location.host}/api/live`);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.openedAt = performance.now();
    socket.onmessage = (event) => {
      if (this.socket !== socket) return;
      if (typeof event.data === 'string') this.readSections(JSON.parse(event.data));
      else this.readVehicles(readFrame(event.data));
    };
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      this.hasEnded ||= event.code === GOING;
      this.dispatchEvent(new CustomEvent('closed', { detail: event.code }));
      if (!this.isWanted) return;
      this.timer = setTimeout(() => this.open(), this.wait * 1000);
      this.wait = Math.min(this.wait * 1.6, MOST_WAIT_S);
    };
  }

  // A proxy may drop a connection without a word: it is opened anew.
  watch() {
    const silence = Math.min(this.silence, (performance.now() - this.openedAt) / 1000);
    if (this.isWanted && this.socket?.readyState === WebSocket.OPEN && silence > 2 * SILENT_S) this.socket.close();
  }

  close() { this.isWanted = false; clearTimeout(this.timer); this.socket?.close(); }

  readSections(message) {
    const names = Object.keys(message.sections);
    if (message.kind === 'hello') {
      this.hasEnded = false;
      this.wait = 0.1;
      this.sections = {};
      this.vehicles.clear();
    }
    for (const name of names) {
      const value = message.sections[name];
      this.sections[name] = value;
      if (name.startsWith('vehicle/')) this.readVehicle(name.slice(8), value);
    }
    if (this.isUnranked) this.rank();
    this.dispatchEvent(new CustomEvent('sections', { detail: { names, isHello: message.kind === 'hello' } }));
  }

  readVehicle(name, facts) {
    this.isUnranked ||= this.vehicles.has(name) === (facts === null);
    if (facts === null) { this.vehicles.delete(name); return; }
    const vehicle = this.vehicles.get(name) ?? { name };
    vehicle.facts = facts;
    this.vehicles.set(name, vehicle);
  }

  // In the order of their names, however they were heard: lists and colours go by it.
  rank() {
    const { compare } = new Intl.Collator('en', { numeric: true });
    const all = [...this.vehicles.values()].sort((a, b) => compare(a.name, b.name));
    this.isUnranked = false;
    this.vehicles = new Map(all.map((vehicle, rank) => [vehicle.name, Object.assign(vehicle, { rank })]));
  }

  readVehicles(frame) {
    this.heardAt = performance.now();
    this.wall = frame.wall;
    this.mission = frame.mission;
    if (frame.vehicles.length) {
      const names = new Map([...this.vehicles.values()].map((vehicle) => [vehicle.facts.number, vehicle]));
      for (const one of frame.vehicles) {
        const vehicle = names.get(one.number);
        if (vehicle) { vehicle.frame = one; vehicle.at = this.heardAt; }
      }
    }
    this.dispatchEvent(new CustomEvent('frame', { detail: frame }));
  }
}

// A request to the server; a refusal is an Error with its reason, in the words of whoever set some:
// this file stands alone, so that other programs can take it (examples/watch_fleet.mjs).
let wordsOf = (text) => text;
export function tellBy(words) { wordsOf = words; }
export async function ask(path, body, deadline = LONGEST_S) {
  const options = body === undefined ? {} : { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body) };
  const answer = await fetch(path, { credentials: 'same-origin', signal: AbortSignal.timeout(deadline * 1000), ...options });
  const content = await answer.json().catch(() => ({}));
  if (!answer.ok) throw Object.assign(new Error(wordsOf(content.error ?? answer.statusText)), { status: answer.status });
  return content;
}
