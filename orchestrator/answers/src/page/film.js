(() => {
  'use strict';
  const data = JSON.parse(document.getElementById('frames').textContent);
  const part = (id) => document.getElementById(id);
  const count = data.time.length;
  const shown = (name, value) => {
    if (value === null) return '–';
    const text = value.toFixed(data.digits[name]);
    return Number(text) === 0 ? text.replace('-', '') : text.replace('-', '\u2212');
  };

  // A smooth closed line through the nodes, the one of the drawing without scripts.
  const PARTS = 4;
  const ring = (radii) => {
    const nodes = radii.length;
    const at = (node) => radii[(node + nodes) % nodes];
    const points = [];
    for (let node = 0; node < nodes; node += 1) {
      const [a, b, c, d] = [at(node - 1), at(node), at(node + 1), at(node + 2)];
      for (let step = 0; step < PARTS; step += 1) {
        const t = step / PARTS;
        const radius = b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
        const angle = (2 * Math.PI * (node + t)) / nodes;
        points.push(`${Math.round(radius * Math.cos(angle))},${Math.round(-radius * Math.sin(angle))}`);
      }
    }
    return `M${points.join('L')}Z`;
  };

  let frame = data.first;
  const show = (wanted) => {
    frame = Math.min(Math.max(wanted, 0), count - 1);
    if (data.ring.length > 0 && data.ring[frame] !== null) part('ring').setAttribute('d', ring(data.ring[frame]));
    const trail = [];
    for (let at = data.from[frame]; at < data.to[frame]; at += 1) trail.push(`${data.x[at]},${-data.y[at]}`);
    part('trail').setAttribute('points', trail.join(' '));
    part('rotor').setAttribute('cx', data.x[data.to[frame] - 1]);
    part('rotor').setAttribute('cy', -data.y[data.to[frame] - 1]);
    if (part('closest')) part('closest').setAttribute('transform', `rotate(${-data.angle[frame]})`);
    for (const name of ['time', 'speed', 'clearance', 'force']) {
      if (part(name)) part(name).textContent = shown(name, data[name][frame]);
    }
    const x = data.strip[0] + ((data.time[frame] - data.time[0]) / (data.time[count - 1] - data.time[0] || 1)) * (data.strip[1] - data.strip[0]);
    part('now').setAttribute('d', data.now.replaceAll('X', x.toFixed(1)));
    const slider = part('slider');
    slider.value = frame;
    slider.setAttribute('aria-valuetext', `${shown('time', data.time[frame])} s`);
  };

  // One frame in 40 ms, or several of them, or one for longer.
  const INTERVAL = 40;
  let isPlaying = false;
  let before = 0;
  const play = (is) => {
    isPlaying = is;
    part('play').textContent = is ? 'Pause' : 'Play';
    if (!is) return;
    if (frame === count - 1) show(0);
    before = performance.now();
    requestAnimationFrame(step);
  };
  const step = (now) => {
    if (!isPlaying) return;
    const passed = Math.floor(((now - before) / INTERVAL) * Number(part('pace').value));
    if (passed > 0) {
      before = now;
      show(frame + passed);
    }
    if (frame === count - 1) play(false);
    else requestAnimationFrame(step);
  };
  part('play').addEventListener('click', () => play(!isPlaying));
  part('slider').addEventListener('input', (event) => { play(false); show(Number(event.target.value)); });
  document.querySelectorAll('[data-frame]').forEach((button) => {
    button.addEventListener('click', () => { play(false); show(Number(button.dataset.frame)); });
  });
  part('controls').hidden = false;
  show(frame);
})();
