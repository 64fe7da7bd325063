// SPDX-License-Identifier: Apache-2.0
// Commands for a run, a draft, a campaign or a vehicle: two presses, then what they print.
import { t } from './texts.js';
import { make } from './format.js';
import { ask } from './link.js';

const SURE_MS = 8000;
const LOOK_MS = 2000;
const SHOWN_LINES = 12;

// A button that begins the command `kind` for what `nameOf` returns, and a box for what it prints.
export function jobButton(kind, nameOf, box) {
  const words = t(`job_${kind}`);
  const button = make('button', { type: 'button', class: 'small', 'data-job': kind, text: words });
  let calm = null;
  const rest = () => { clearTimeout(calm); calm = null; button.textContent = words; };
  button.addEventListener('click', async () => {
    if (!calm) { button.textContent = t('job_sure', { job: words }); calm = setTimeout(rest, SURE_MS); return; }
    rest();
    button.disabled = true;
    const name = nameOf();
    const path = `/api/jobs/${kind}/${encodeURIComponent(name)}`;
    await follow(kind, name, box, ask(path, {})).catch((error) => { box.replaceChildren(make('p', { class: 'warn', text: error.message })); });
    button.disabled = false;
  });
  return button;
}

async function follow(kind, name, box, begun) {
  const path = `/api/jobs/${kind}/${encodeURIComponent(name)}`;
  box.replaceChildren(make('p', { class: 'note', text: t('run_working') }));
  for (let job = await begun; ; job = await ask(path)) {
    const state = make('b', { text: t(`job_${job.state}`, { job: t(`job_${kind}`), name }) });
    const end = make('button', { type: 'button', class: 'small', text: t('job_end'), onclick: () => ask(`${path}/end`, {}).catch(() => {}) });
    const text = job.text.split('\n').slice(-SHOWN_LINES).join('\n');
    box.replaceChildren(make('p', { class: 'draft-row', role: 'status' }, state, job.state === 'running' ? end : ''), text ? make('pre', { class: 'draft-output', tabindex: 0, text }) : '');
    if (job.state !== 'running' || !box.isConnected) return;
    await new Promise((resolve) => { setTimeout(resolve, LOOK_MS); });
  }
}
