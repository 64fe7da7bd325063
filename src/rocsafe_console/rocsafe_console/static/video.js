// SPDX-License-Identifier: Apache-2.0
// The camera of one vehicle. Nothing is sent while nobody looks.
import { t } from './texts.js';
import { age, make } from './format.js';
import { STALE_S } from './link.js';

const HEAD_BYTES = 8;
const AGAIN_S = 1;
// The live view of `rocsafe scene show`.
const SCENE = 'scene';

export class Video {
  constructor(element, link) {
    this.link = link;
    this.choice = make('select', { id: 'video-vehicle', 'aria-label': t('video_vehicle'), onchange: () => this.turn() });
    this.picture = make('img', { class: 'newest', alt: '', hidden: true });
    this.word = make('p', { class: 'line', role: 'status' });
    element.append(this.choice, this.picture, this.word);
    link.addEventListener('sections', () => this.offer());
    document.addEventListener('visibilitychange', () => this.turn());
    setInterval(() => this.tell(), 500);
    this.offer();
  }

  offer() {
    const names = [...this.link.vehicles.keys(), SCENE];
    if (this.offered === names.join()) return;
    this.offered = names.join();
    const chosen = this.choice.value;
    this.choice.replaceChildren(make('option', { value: '', text: t('video_none') }), ...names.map((name) => make('option', { value: name, text: name === SCENE ? t('video_scene') : name })));
    this.choice.value = names.includes(chosen) ? chosen : '';
    if (this.choice.value !== chosen) this.turn();
  }

  // Begins to look, or ends it: what is chosen, and only while the page is seen.
  turn() {
    const isSeen = !document.hidden && (document.documentElement.dataset.view ?? 'live') === 'live';
    const wanted = isSeen ? this.choice.value : '';
    if (this.vehicle === wanted && this.socket) return;
    clearTimeout(this.timer);
    this.socket?.close();
    this.socket = null;
    this.vehicle = wanted;
    this.taken = NaN;
    this.picture.hidden = true;
    if (wanted) this.begin();
    this.tell();
  }

  begin() {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    const socket = this.socket = new WebSocket(`${scheme}://${location.host}/api/video/${encodeURIComponent(this.vehicle)}`);
    socket.binaryType = 'arraybuffer';
    socket.onmessage = ({ data }) => { if (this.socket === socket) this.show(data); };
    socket.onclose = () => { if (this.socket === socket) this.timer = setTimeout(() => this.begin(), AGAIN_S * 1000); };
  }

  show(data) {
    this.taken = new DataView(data).getFloat64(0, true);
    const url = URL.createObjectURL(new Blob([new Uint8Array(data, HEAD_BYTES)], { type: 'image/jpeg' }));
    const before = this.url;
    this.url = url;
    this.picture.onload = () => { if (before) URL.revokeObjectURL(before); };
    this.picture.src = url;
    this.picture.alt = t('video_of', { vehicle: this.vehicle });
    this.picture.hidden = false;
    this.tell();
  }

  tell() {
    const seconds = this.link.now - this.taken;
    const isOld = !this.link.isLive || !(seconds <= STALE_S);
    this.picture.classList.toggle('old-picture', isOld);
    const text = !this.vehicle ? '' : Number.isNaN(this.taken) ? t('video_waiting') : t(isOld ? 'video_old' : 'video_live', { age: age(Math.max(seconds, 0)) });
    if (this.word.textContent !== text) this.word.textContent = text;
  }
}
