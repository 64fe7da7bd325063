// SPDX-License-Identifier: Apache-2.0
'use strict';
(() => {
  const root = document.documentElement;
  root.classList.add('has-script');
  const $ = (selector, within = document) => within.querySelector(selector);
  const $$ = (selector, within = document) => [...within.querySelectorAll(selector)];
  const data = JSON.parse($('#report-data').textContent);

  // Theme: the system's until somebody chooses. Storage may be refused to files.
  const themeButton = $('#theme');
  const systemDark = matchMedia('(prefers-color-scheme: dark)');
  const isDark = () => (root.dataset.theme || (systemDark.matches ? 'dark' : 'light')) === 'dark';
  const nameTheme = () => { themeButton.textContent = isDark() ? 'Light' : 'Dark'; };
  try { if (localStorage.rocsafeTheme) root.dataset.theme = localStorage.rocsafeTheme; } catch { /* none */ }
  themeButton.addEventListener('click', () => {
    root.dataset.theme = isDark() ? 'light' : 'dark';
    try { localStorage.rocsafeTheme = root.dataset.theme; } catch { /* none */ }
    nameTheme();
  });
  systemDark.addEventListener('change', nameTheme);
  nameTheme();

  const clock = (seconds) => {
    const whole = Math.max(Math.round(seconds), 0);
    const two = (value) => String(value).padStart(2, '0');
    const hours = Math.floor(whole / 3600);
    const rest = `${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
    return hours ? `${hours}:${rest}` : rest;
  };
  const doseText = (value) => {
    const [scaled, unit] = value >= 1e6 ? [value / 1e6, 'Sv/h'] : value >= 1e3 ? [value / 1e3, 'mSv/h'] : [value, 'µSv/h'];
    return `${Number(scaled.toPrecision(3))} ${unit}`;
  };

  const svg = $('.map');
  if (svg) startMap(svg);

  function startMap(map) {
    const frame = map.parentElement;
    const { readings, photos, tracks, boxes } = data;
    const NS = 'http://www.w3.org/2000/svg';
    let box = boxes.region.slice();

    // Where we look: `box` is what has to be in view; the browser centres it.
    const scale = () => Math.max(box[2] / map.clientWidth, box[3] / map.clientHeight);
    function show() {
      map.setAttribute('viewBox', box.map((value) => value.toFixed(2)).join(' '));
      map.style.setProperty('--k', scale());
      const wanted = 110 * scale();
      const power = 10 ** Math.floor(Math.log10(wanted));
      const metres = [5, 2, 1].map((step) => step * power).find((value) => value <= wanted) || power;
      $('.scale-line').style.width = `${metres / scale()}px`;
      $('.scale-text').textContent = metres >= 1000 ? `${metres / 1000} km` : `${metres} m`;
    }
    function toMap(event) {
      const point = new DOMPoint(event.clientX, event.clientY);
      return point.matrixTransform(map.getScreenCTM().inverse());
    }
    function zoom(factor, at = { x: box[0] + box[2] / 2, y: box[1] + box[3] / 2 }) {
      const width = Math.min(Math.max(box[2] * factor, 4), 20000);
      const real = width / box[2];
      box = [at.x + (box[0] - at.x) * real, at.y + (box[1] - at.y) * real, width, box[3] * real];
      show();
    }
    function pan(dx, dy) { box[0] += dx * scale(); box[1] += dy * scale(); show(); }
    function fit(name) { box = boxes[name].slice(); show(); }
    const actions = { in: () => zoom(0.66), out: () => zoom(1.5), region: () => fit('region'), all: () => fit('all') };
    $$('[data-zoom]').forEach((button) => button.addEventListener('click', actions[button.dataset.zoom]));
    map.addEventListener('keydown', (event) => {
      const step = 60;
      const keys = {
        ArrowLeft: () => pan(-step, 0), ArrowRight: () => pan(step, 0),
        ArrowUp: () => pan(0, -step), ArrowDown: () => pan(0, step),
        '+': actions.in, '=': actions.in, '-': actions.out, 0: actions.region, a: actions.all, A: actions.all,
      };
      if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      keys[event.key]();
    });

    // One finger scrolls the page, two move the map; a mouse drags it.
    const pointers = new Map();
    let moved = 0;
    map.addEventListener('pointerdown', (event) => {
      pointers.set(event.pointerId, event);
      moved = pointers.size > 1 ? 99 : 0;
    });
    map.addEventListener('pointermove', (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const dx = event.clientX - before.clientX;
      const dy = event.clientY - before.clientY;
      const other = [...pointers.values()].find((pointer) => pointer.pointerId !== event.pointerId);
      if (other) {
        const apart = (pointer) => Math.hypot(pointer.clientX - other.clientX, pointer.clientY - other.clientY);
        zoom(apart(before) / Math.max(apart(event), 1), toMap(other));
        pan(-dx / 2, -dy / 2);
      } else if (event.pointerType === 'mouse') {
        if (moved > 3) {
          map.setPointerCapture(event.pointerId);
          map.classList.add('dragging');
        }
        pan(-dx, -dy);
      }
      moved += Math.abs(dx) + Math.abs(dy);
      pointers.set(event.pointerId, event);
    });
    const lift = (event) => { pointers.delete(event.pointerId); map.classList.remove('dragging'); };
    map.addEventListener('pointerup', lift);
    map.addEventListener('pointercancel', lift);
    map.addEventListener('touchmove', (event) => { if (event.touches.length > 1) event.preventDefault(); }, { passive: false });
    const hint = $('.map-hint');
    let hintTimer = 0;
    map.addEventListener('wheel', (event) => {
      if (!event.ctrlKey && !event.metaKey) {
        hint.classList.add('shown');
        clearTimeout(hintTimer);
        hintTimer = setTimeout(() => hint.classList.remove('shown'), 1400);
        return;
      }
      event.preventDefault();
      zoom(Math.exp(Math.max(Math.min(event.deltaY, 60), -60) / 160), toMap(event));
    }, { passive: false });
    new ResizeObserver(show).observe(frame);

    // Layers.
    const switches = $$('[data-switch]');
    const views = $$('[data-view]');
    function applyLayers() {
      const shown = switches.filter((box) => box.checked).map((box) => box.dataset.switch);
      switches.forEach((box) => map.classList.toggle(`hide-${box.dataset.switch}`, !box.checked));
      map.classList.toggle('show-dose', shown.includes('readings'));
      views.forEach((button) => {
        const wanted = button.dataset.view.split(' ');
        const same = switches.every((box) => box.disabled || box.checked === wanted.includes(box.dataset.switch));
        button.setAttribute('aria-pressed', same);
      });
    }
    switches.forEach((box) => box.addEventListener('change', applyLayers));
    views.forEach((button) => button.addEventListener('click', () => {
      const wanted = button.dataset.view.split(' ');
      switches.forEach((box) => { box.checked = !box.disabled && wanted.includes(box.dataset.switch); });
      applyLayers();
    }));

    // Details of one reading or photograph.
    const details = $('#details');
    const picked = document.createElementNS(NS, 'g');
    picked.setAttribute('class', 'pin');
    picked.innerHTML = '<circle class="picked" r="9"></circle>';
    const footprint = document.createElementNS(NS, 'polygon');
    footprint.setAttribute('class', 'footprint');
    map.insertBefore(footprint, $('.layer-photos'));
    const place = (node, x, y) => { node.style.transform = `translate(${x}px,${y}px) scale(var(--k))`; };
    const position = (x, y) => {
      const latitude = data.origin[0] - y / data.perDegree[0];
      const longitude = data.origin[1] + x / data.perDegree[1];
      const text = (value, plus, minus) => `${Math.abs(value).toFixed(5)}° ${value >= 0 ? plus : minus}`;
      return `${text(latitude, 'N', 'S')}, ${text(longitude, 'E', 'W')}`;
    };
    function line(tag, text) {
      const node = document.createElement(tag);
      node.textContent = text;
      return node;
    }
    function mark(x, y, ground = '') {
      place(picked, x, y);
      map.append(picked);
      footprint.setAttribute('points', ground);
    }
    function pickReading(index, isMarked = true) {
      const { x, y, t, d, v } = readings;
      if (isMarked) mark(x[index], y[index]);
      details.replaceChildren(
        line('b', doseText(d[index])),
        line('div', `${data.vehicles[v[index]]} at ${clock(t[index])}`),
        line('div', position(x[index], y[index])),
        line('div', index === data.highest ? 'The highest reading. Click a track or a photograph mark for others.' : ''),
      );
    }
    function pickPhoto(id, bringIntoView) {
      const photo = photos[id];
      if (!photo) return;
      $$('.selected').forEach((node) => node.classList.remove('selected'));
      $$('[data-shot]').filter((node) => node.dataset.shot === id).forEach((node) => node.classList.add('selected'));
      const [x, y, t, v, viewpoint, ground] = photo;
      mark(x, y, ground);
      const picture = $$('.gallery button').find((node) => node.dataset.shot === id);
      const link = line('a', 'Full photograph');
      link.href = `images/${encodeURIComponent(id)}.jpg`;
      details.replaceChildren(...(picture ? [$('img', picture).cloneNode()] : []), line('b', id),
        line('div', `${data.vehicles[v]} at ${clock(t)}, viewpoint ${viewpoint}`), line('div', position(x, y)), link);
      if (bringIntoView) frame.scrollIntoView({ block: 'nearest', behavior: 'smooth' });
    }
    map.addEventListener('click', (event) => {
      if (moved > 6) return;
      const photo = event.target.closest('[data-shot]');
      if (photo) { pickPhoto(photo.dataset.shot); return; }
      const at = toMap(event);
      let best = -1;
      let least = (16 * scale()) ** 2;
      readings.x.forEach((x, index) => {
        const apart = (x - at.x) ** 2 + (readings.y[index] - at.y) ** 2;
        if (apart < least) { least = apart; best = index; }
      });
      if (best >= 0) pickReading(best);
    });
    $$('.gallery button').forEach((button) => button.addEventListener('click', () => {
      const photoSwitch = switches.find((box) => box.dataset.switch === 'photos');
      photoSwitch.checked = true;
      applyLayers();
      pickPhoto(button.dataset.shot, true);
    }));

    // Replay: where everybody was at a time; the charts move it too.
    const slider = $('#replay');
    const drones = $$('.drone-pin');
    function whereAt(track, seconds) {
      const { t, x, y } = track;
      let low = 0;
      let high = t.length - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (t[middle] <= seconds) low = middle; else high = middle;
      }
      const share = t[high] > t[low] ? Math.min(Math.max((seconds - t[low]) / (t[high] - t[low]), 0), 1) : 0;
      return [x[low] + (x[high] - x[low]) * share, y[low] + (y[high] - y[low]) * share];
    }
    function replayAt(seconds) {
      map.classList.add('replaying');
      $('#replay-time').textContent = clock(seconds);
      drones.forEach((drone) => place(drone, ...whereAt(tracks[drone.dataset.vehicle], seconds)));
    }
    if (slider) {
      const play = $('#replay-play');
      let playing = 0;
      const stop = () => {
        cancelAnimationFrame(playing);
        playing = 0;
        play.textContent = '▶';
        play.setAttribute('aria-label', 'Play');
      };
      slider.addEventListener('input', () => { stop(); replayAt(Number(slider.value)); });
      play.addEventListener('click', () => {
        if (playing) { stop(); return; }
        const end = Number(slider.max);
        // The whole mission in half a minute.
        let seconds = Number(slider.value) >= end ? 0 : Number(slider.value);
        let before = performance.now();
        play.textContent = '❚❚';
        play.setAttribute('aria-label', 'Pause');
        const tick = (now) => {
          seconds += (now - before) / 1000 * end / 30;
          before = now;
          slider.value = Math.min(seconds, end);
          replayAt(Math.min(seconds, end));
          if (seconds < end) playing = requestAnimationFrame(tick); else stop();
        };
        playing = requestAnimationFrame(tick);
      });
      document.addEventListener('chart-time', (event) => {
        stop();
        slider.value = event.detail;
        replayAt(event.detail);
      });
    }
    applyLayers();
    show();
    if (data.highest !== null) pickReading(data.highest, false);
  }

  // Charts: the time under the pointer, what was measured then, and where everybody was.
  function startCharts() {
    const { readings, vehicles } = data;
    const byVehicle = vehicles.map(() => []);
    readings.t.forEach((_, index) => byVehicle[readings.v[index]].push(index));
    function nearest(indices, seconds) {
      let low = 0;
      let high = indices.length - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (readings.t[indices[middle]] <= seconds) low = middle; else high = middle;
      }
      const best = [indices[low], indices[high]].sort((a, b) =>
        Math.abs(readings.t[a] - seconds) - Math.abs(readings.t[b] - seconds))[0];
      return best !== undefined && Math.abs(readings.t[best] - seconds) < 3 ? best : -1;
    }
    $$('.chart-box').forEach((holder) => {
      const tip = document.createElement('div');
      tip.className = 'tip';
      holder.append(tip);
      const leave = () => { tip.textContent = ''; $$('.cursor').forEach((cursor) => { cursor.style.visibility = ''; }); };
      holder.addEventListener('pointerleave', leave);
      holder.addEventListener('pointermove', (event) => {
        const chart = event.target.closest('.chart');
        if (!chart) return;
        const { left, right, end } = chart.dataset;
        const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(chart.getScreenCTM().inverse());
        const seconds = (at.x - left) / (right - left) * end;
        if (seconds < 0 || seconds > Number(end)) { leave(); return; }
        $$('.cursor').forEach((cursor) => {
          const own = cursor.closest('.chart').dataset;
          const x = Number(own.left) + (own.right - own.left) * seconds / own.end;
          cursor.style.visibility = 'visible';
          cursor.style.transform = `translateX(${x}px)`;
        });
        const lines = byVehicle.map((indices, number) => {
          const index = nearest(indices, seconds);
          return index < 0 ? '' : `${vehicles[number]} ${doseText(readings.d[index])}`;
        }).filter(Boolean).slice(0, 8);
        tip.textContent = [clock(seconds), ...lines].join('  ·  ');
        const inside = event.clientX - holder.getBoundingClientRect().left;
        const most = holder.clientWidth - tip.offsetWidth;
        tip.style.left = `${Math.max(Math.min(inside + 14, most), 0)}px`;
        document.dispatchEvent(new CustomEvent('chart-time', { detail: seconds }));
      });
    });
  }
  if (data.readings) startCharts();
})();
