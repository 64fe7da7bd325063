// SPDX-License-Identifier: Apache-2.0
// Alarms that are heard. A browser plays nothing before the first click, and the button says so.
const REPEAT_S = 5;
// Three high tones: critical; one lower tone: warning.
const TONES = { critical: [[0, 880], [0.25, 880], [0.5, 880]], warning: [[0, 520]] };
const TONE_S = 0.2;

export class Sound extends EventTarget {
  constructor() {
    super();
    this.isMuted = false;
    this.played = [];
    this.newest = 0;
    this.open = [];
    const wake = () => this.wake();
    for (const name of ['pointerdown', 'keydown']) addEventListener(name, wake, { capture: true });
    setInterval(() => this.repeat(), REPEAT_S * 1000);
  }

  // 'waiting' for a click, 'on' or 'off'.
  get state() { return this.isMuted ? 'off' : this.audio?.state === 'running' ? 'on' : 'waiting'; }

  wake() {
    if (this.audio?.state === 'running') return;
    this.audio ??= new AudioContext();
    this.audio.onstatechange = () => this.tell();
    this.audio.resume().then(() => this.tell(), () => this.tell());
  }

  toggle() {
    this.isMuted = !this.isMuted;
    this.tell();
    if (!this.isMuted) this.play('warning');
  }

  tell() { this.dispatchEvent(new CustomEvent('state', { detail: this.state })); }

  // What is new is heard once; critical alarms that nobody has seen, again and again.
  hear(alarms, isHello) {
    this.open = alarms.filter((one) => !one.seen_by);
    const fresh = this.open.filter((one) => one.number > this.newest);
    this.newest = Math.max(this.newest, ...alarms.map((one) => one.number));
    if (isHello) this.repeat();
    else if (fresh.length) this.play(fresh.some((one) => one.severity === 'critical') ? 'critical' : 'warning');
  }

  repeat() { if (this.open.some((one) => one.severity === 'critical')) this.play('critical'); }

  play(severity) {
    if (this.state !== 'on') return;
    this.played = [...this.played, severity].slice(-100);
    const now = this.audio.currentTime;
    for (const [start, frequency] of TONES[severity]) {
      const tone = this.audio.createOscillator();
      const gain = this.audio.createGain();
      tone.frequency.value = frequency;
      gain.gain.setValueAtTime(0.25, now + start);
      gain.gain.linearRampToValueAtTime(0, now + start + TONE_S);
      tone.connect(gain).connect(this.audio.destination);
      tone.start(now + start);
      tone.stop(now + start + TONE_S);
    }
  }
}
