// SPDX-License-Identifier: Apache-2.0
// Watches the vehicles of a mission from JavaScript, and gives them an order. Needs no package.
//
//   rocsafe console --runs runs        prints an address: take it whole, with its token
//   node --experimental-websocket examples/watch_fleet.mjs ADDRESS [SECONDS] [VERB]
//
// VERB is hold, resume, return or land; it goes to all vehicles after SECONDS (3 by default).
// Node.js 22 and later need no --experimental-websocket.
import { randomBytes } from 'node:crypto';

const STATES = [
  'unknown', 'disarmed', 'armed', 'taking off', 'flying', 'holding', 'returning', 'landing', 'landed', 'lost',
  'crashed', 'waiting',
];

// Each line is a JSON object, for other programs.
const say = (line) => console.log(JSON.stringify(line));
const rounded = (value, digits) => (Number.isNaN(value) ? null : Number(value.toFixed(digits)));

class Console {
  constructor(address) {
    const url = new URL(address);
    this.origin = url.origin;
    this.token = new URLSearchParams(url.hash.slice(1)).get('token');
    this.vehicles = new Map();
  }

  // The server takes only what comes from its own page, of somebody who is logged in.
  get headers() { return { Origin: this.origin, Cookie: this.cookie ?? '' }; }

  async ask(path, body) {
    const answer = await fetch(this.origin + path, {
      method: 'POST', headers: { ...this.headers, 'Content-Type': 'application/json' }, body: JSON.stringify(body),
    });
    this.cookie = answer.headers.get('Set-Cookie')?.split(';')[0] ?? this.cookie;
    const content = await answer.json();
    if (!answer.ok) throw new Error(`${path}: ${content.error ?? answer.statusText}`);
    return content;
  }

  async open() {
    if (!this.token) throw new Error('ADDRESS: must be as the console prints it, with #token=...');
    await this.ask('/api/token', { token: this.token });
    // The page's own reader of frames, so that it always fits the server.
    const source = await (await fetch(`${this.origin}/static/link.js`)).text();
    const { readFrame } = await import(`data:text/javascript,${encodeURIComponent(source)}`);
    this.socket = new WebSocket(`${this.origin.replace('http', 'ws')}/api/live`, { headers: this.headers });
    this.socket.binaryType = 'arraybuffer';
    this.socket.onmessage = ({ data }) => {
      if (typeof data === 'string') this.readSections(JSON.parse(data).sections);
      else this.readVehicles(readFrame(data));
    };
    return new Promise((resolve, reject) => {
      this.socket.onopen = resolve;
      this.socket.onerror = () => reject(new Error('/api/live: the server closed the connection'));
    });
  }

  readSections(sections) {
    for (const [name, facts] of Object.entries(sections)) {
      if (!name.startsWith('vehicle/')) continue;
      if (facts === null) this.vehicles.delete(name.slice(8));
      else this.vehicles.set(name.slice(8), facts);
    }
  }

  readVehicles(frame) {
    const names = new Map([...this.vehicles].map(([name, facts]) => [facts.number, name]));
    for (const one of frame.vehicles) {
      const vehicle = names.get(one.number);
      if (!vehicle) continue;
      say({
        vehicle, state: STATES[one.state] ?? 'unknown', latitude_deg: rounded(one.latitude, 7),
        longitude_deg: rounded(one.longitude, 7), height_m: rounded(one.height, 1),
        battery: rounded(one.battery, 2), dose_rate_usvh: rounded(one.doseRate, 3), age_s: rounded(one.age, 1),
      });
    }
  }

  // Two steps, as on the page; a vehicle whose state has changed since `revision` does not obey.
  async order(verb) {
    const revisions = Object.fromEntries([...this.vehicles].map(([name, facts]) => [name, facts.revision]));
    const requestId = randomBytes(16).toString('hex');
    await this.ask('/api/orders', { request_id: requestId, verb, revisions });
    return (await this.ask(`/api/orders/${requestId}/confirm`, {})).results;
  }

  close() { this.socket?.close(); }
}

const [address, seconds = '3', verb] = process.argv.slice(2);
try {
  if (!address || !(Number(seconds) >= 0)) throw new Error('usage: watch_fleet.mjs ADDRESS [SECONDS] [VERB]');
  if (typeof WebSocket === 'undefined') throw new Error('no WebSocket here: run node --experimental-websocket');
  const link = new Console(address);
  try {
    await link.open();
    await new Promise((resolve) => { setTimeout(resolve, 1000 * Number(seconds)); });
    if (verb) for (const result of await link.order(verb)) say({ order: verb, ...result });
  } finally {
    link.close();
  }
} catch (error) {
  console.error(`watch_fleet: ${error.cause?.message ?? error.message}`);
  process.exitCode = 1;
}
