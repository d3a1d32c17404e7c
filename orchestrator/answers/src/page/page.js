(() => {
  'use strict';
  const root = document.documentElement;
  const figures = JSON.parse(document.getElementById('figures').textContent);
  const config = { displaylogo: false, responsive: true, doubleClick: 'reset+autosize',
    showSendToCloud: false,
    modeBarButtonsToRemove: ['select2d', 'lasso2d', 'autoScale2d', 'sendChartToCloud', 'sendDataToCloud'], toImageButtonOptions: { format: 'svg' } };

  // "@c0" and "@c0/0.2" are colours of the page: they change with light and dark.
  const colour = (text) => {
    const [name, opacity] = text.slice(1).split('/');
    const value = getComputedStyle(root).getPropertyValue('--' + name).trim();
    if (opacity === undefined) return value;
    const part = (at) => parseInt(value.slice(at, at + 2), 16);
    return `rgba(${part(1)},${part(3)},${part(5)},${opacity})`;
  };
  const coloured = (value) => {
    if (typeof value === 'string') return /^@[a-z]+[0-9]?(\/[0-9.]+)?$/.test(value) ? colour(value) : value;
    if (Array.isArray(value)) return typeof value[0] === 'number' ? value : value.map(coloured);
    if (value === null || typeof value !== 'object') return value;
    return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, coloured(inner)]));
  };
  // Figures side by side are below one another in a narrow page.
  const NARROW = 760;
  const isNarrow = () => document.body.clientWidth < NARROW;
  const axis = (own) => ({ gridcolor: '@grid', linecolor: '@line', zerolinecolor: '@line', showline: true, ticks: 'outside',
    tickcolor: '@line', automargin: true, exponentformat: 'power', ...own,
    title: { standoff: 8, ...own.title } });
  // Titles and names of a narrow page are broken at spaces, dots and underscores into lines of 22 letters.
  const broken = (text) => {
    let line = 0;
    return text.split(/(?<=[ ._])/).map((part) => {
      const fits = line === 0 || line + part.length <= 22;
      line = part.length + (fits ? line : 0);
      return fits ? part : '<br>' + part;
    }).join('');
  };
  // The height that further lines of a title take [px]; names have room beside their bars.
  const breakAxis = (axis, isAcross) => {
    if (!isAcross && axis.ticktext) axis.ticktext = axis.ticktext.map(broken);
    if (!isAcross || !axis.title.text) return 0;
    axis.title.text = broken(axis.title.text);
    return 20 * (axis.title.text.split('<br>').length - 1);
  };
  const layout = (own) => {
    const axes = Object.keys(own).filter((key) => /^[xy]axis/.test(key));
    const all = { paper_bgcolor: '@paper', plot_bgcolor: '@paper', font: { color: '@ink', family: 'system-ui, sans-serif', size: 13 },
      margin: { l: 64, r: 16, t: 34, b: 48 }, hovermode: 'closest', dragmode: 'zoom', height: 400,
      hoverlabel: { namelength: -1 }, modebar: { bgcolor: 'rgba(0,0,0,0)', color: '@quiet', activecolor: '@ink' }, ...own };
    for (const key of new Set(['xaxis', 'yaxis', ...axes])) {
      all[key] = axis(own[key] || {});
      if (isNarrow()) all.height += breakAxis(all[key], key.startsWith('x'));
    }
    return coloured(all);
  };

  // Points whose axes the reader chooses.
  const symbols = ['circle', 'x', 'diamond', 'square', 'triangle-up', 'cross', 'star', 'hourglass'];
  const safe = (text) => text.replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/\$/g, '\uff04');
  const explorer = (data, [x, y]) => {
    const traces = data.kinds.map((name, kind) => {
      const rows = data.kind.flatMap((of, row) => (of === kind ? [row] : []));
      const good = kind === 0;
      return { type: 'scatter', mode: 'markers', name: safe(name), x: rows.map((row) => data.columns[x][row]),
        y: rows.map((row) => data.columns[y][row]), customdata: rows.map((row) => data.samples[row]),
        hovertemplate: '%{x}, %{y}<br>sample %{customdata}', marker: { symbol: symbols[good ? 0 : 1 + ((kind - 1) % 7)], size: good ? 5 : 9,
          color: good ? '@quiet/0.45' : `@c${[1, 0, 2, 3, 5, 4, 6][(kind - 1) % 7]}` } };
    });
    const title = (at) => {
      const words = data.words[at].map(safe);
      const ticks = words.length ? { tickvals: words.map((_, place) => place), ticktext: words } : {};
      return { title: { text: safe(data.labels[at]) }, ...ticks };
    };
    return { traces, layout: { xaxis: title(x), yaxis: title(y), height: 482, margin: { l: 64, r: 16, t: 34, b: 96 },
      legend: { orientation: 'h', x: 0, yref: 'container', y: 0, yanchor: 'bottom' } } };
  };
  const chooser = (figure, plot, data) => {
    const shown = [...data.first];
    const row = document.createElement('div');
    row.className = 'choose';
    ['Across', 'Up'].forEach((word, at) => {
      const label = document.createElement('label');
      const select = document.createElement('select');
      data.labels.forEach((name, value) => select.add(new Option(name, value, false, value === shown[at])));
      select.addEventListener('change', () => { shown[at] = Number(select.value); draw(figure); });
      label.append(word + ' ', select);
      row.append(label);
    });
    figure.insertBefore(row, plot);
    return () => explorer(data, shown);
  };

  // Arrows move, + and - zoom, 0 shows all again.
  const keys = (event) => {
    const plot = event.currentTarget;
    if (event.target !== plot || event.ctrlKey || event.metaKey || event.altKey) return;
    const change = {};
    for (const [name, back, ahead] of [['xaxis', 'ArrowLeft', 'ArrowRight'], ['yaxis', 'ArrowDown', 'ArrowUp']]) {
      const [low, high] = plot._fullLayout[name].range.map(Number);
      const width = high - low;
      if (!Number.isFinite(width)) continue;
      if (event.key === '0') change[name + '.autorange'] = true;
      else if (event.key === '+' || event.key === '=') change[name + '.range'] = [low + width / 6, high - width / 6];
      else if (event.key === '-') change[name + '.range'] = [low - width / 4, high + width / 4];
      else if (event.key === back) change[name + '.range'] = [low - width / 8, high - width / 8];
      else if (event.key === ahead) change[name + '.range'] = [low + width / 8, high + width / 8];
    }
    if (Object.keys(change).length === 0) return;
    event.preventDefault();
    Plotly.relayout(plot, change);
  };

  const sources = new Map();
  const draw = (figure) => {
    const data = sources.get(figure)();
    const { narrow, ...wide } = data.layout;
    const own = narrow && isNarrow() ? { ...wide, ...narrow } : wide;
    return Plotly.react(figure.querySelector('.plot'), coloured(data.traces), layout(own), config);
  };
  root.classList.add('scripts');
  let drawn = 0;
  const all = Object.entries(figures).map(([id, data]) => {
    const figure = document.getElementById(id);
    const plot = figure.querySelector('.plot');
    sources.set(figure, data.explorer ? chooser(figure, plot, data.explorer) : () => data);
    plot.hidden = false;
    plot.tabIndex = 0;
    plot.setAttribute('role', 'group');
    plot.setAttribute('aria-label', figure.querySelector('figcaption').textContent);
    plot.addEventListener('keydown', keys);
    figure.classList.add('drawn');
    return draw(figure).then(() => { drawn += 1; }, (error) => {
      // the drawing is still there
      plot.hidden = true;
      figure.classList.remove('drawn');
      console.error(error);
    });
  });
  Promise.all(all).then(() => { root.dataset.drawn = `${drawn} of ${all.length}`; });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => sources.forEach((_, figure) => draw(figure)));
  let was = isNarrow();
  addEventListener('resize', () => {
    if (was === isNarrow()) return;
    was = isNarrow();
    sources.forEach((_, figure) => draw(figure));
  });
  const open = (is) => document.querySelectorAll('main details').forEach((details) => { details.open = is; });
  addEventListener('beforeprint', () => open(true));
  addEventListener('afterprint', () => open(false));
})();
