// SPDX-License-Identifier: Apache-2.0
// A new mission: drawn, checked, planned, approved and launched.
import { t } from './texts.js';
import { make } from './format.js';

export class Draft {
  constructor(panel, map, link) {
    this.panel = panel;
    this.map = map;
    this.link = link;
    this.isDrawing = false;
  }

  async show() {
    this.panel.replaceChildren(make('h2', { text: t('draft_title') }));
  }

  onPlace() {}
}
