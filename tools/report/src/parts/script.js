(function () {
  'use strict';
  var root = document.documentElement, MINUS = '\u2212';
  function all(where, what) { return [].slice.call(where.querySelectorAll(what)); }
  function number(value, digits) {
    return value === null || value === undefined ? '\u2013' : (value < 0 ? MINUS : '') + Math.abs(value).toFixed(digits);
  }

  // Light and dark: as the system says, until the button says otherwise.
  var button = document.getElementById('theme'), KEY = 'slipstream-theme';
  function isDark() {
    return root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme:dark)').matches;
  }
  try { var kept = localStorage.getItem(KEY); if (kept) root.dataset.theme = kept; } catch (error) { /* a file without storage */ }
  if (button) {
    button.setAttribute('aria-pressed', isDark());
    button.onclick = function () {
      root.dataset.theme = isDark() ? 'light' : 'dark';
      button.setAttribute('aria-pressed', isDark());
      try { localStorage.setItem(KEY, root.dataset.theme); } catch (error) { /* the same */ }
    };
  }

  // Copy.
  function copied(source, target) {
    var words = target.textContent;
    function done() { target.textContent = 'Copied'; setTimeout(function () { target.textContent = words; }, 1200); }
    function byHand() {
      var area = document.createElement('textarea');
      area.value = source; document.body.appendChild(area); area.select(); document.execCommand('copy'); area.remove(); done();
    }
    if (navigator.clipboard) navigator.clipboard.writeText(source).then(done, byHand); else byHand();
  }
  all(document, '[data-copy]').forEach(function (own) {
    own.onclick = function () { copied(document.getElementById(own.dataset.copy).textContent.trim(), own); };
  });

  // Tables: a click on a head sorts by it.
  all(document, 'th[aria-sort]').forEach(function (head) {
    head.querySelector('button').onclick = function () {
      var up = head.getAttribute('aria-sort') !== 'ascending', table = head.closest('table'), body = table.tBodies[0];
      function key(row) { var cell = row.cells[head.cellIndex]; return cell.dataset.s || cell.textContent; }
      all(table, 'th[aria-sort]').forEach(function (other) { other.setAttribute('aria-sort', 'none'); });
      head.setAttribute('aria-sort', up ? 'ascending' : 'descending');
      [].slice.call(body.rows).sort(function (p, q) {
        var a = key(p), z = key(q), d = a - z;
        if (isNaN(d)) d = a < z ? -1 : a > z ? 1 : 0;
        return up ? d : -d;
      }).forEach(function (row) { body.appendChild(row); });
    };
  });

  // Rows over one time axis: cursor, zoom, and which spans are shaded.
  function step(least) {
    var power = Math.pow(10, Math.floor(Math.log10(least))), steps = [1, 2, 2.5, 5, 10];
    for (var i = 0; i < steps.length; i++) if (steps[i] * power >= least * (1 - 1e-9)) return steps[i] * power;
    return 10 * power;
  }
  function group(box) {
    var data = JSON.parse(document.getElementById(box.dataset.cursor).textContent), t = data.t, lo = data.lo, hi = data.hi;
    var frames = all(box, '.fr[data-t]'), input = box.querySelector('.scrub'), a = 0, b = 1, place = 0;
    if (!frames.length) return;
    var unit = (frames[frames.length - 1].querySelector('.xt:last-of-type') || {}).textContent || '';
    unit = unit.replace(/^[^a-zA-Z%]*/, '');
    var ticks = all(frames[frames.length - 1], '.xt').map(function (own) { return own.outerHTML; }).join('');
    input.max = Math.max(t.length - 1, 0);
    function show(i) {
      if (!t.length) return;
      place = Math.max(0, Math.min(t.length - 1, i));
      var share = (t[place] - lo) / (hi - lo), words = 't = ' + number(t[place], 2) + ' ' + (unit || 's');
      box.classList.toggle('on', share >= a && share <= b);
      box.style.setProperty('--cx', share);
      input.value = place; input.setAttribute('aria-valuetext', words);
      all(box, '[data-v]').forEach(function (own) {
        own.textContent = own.dataset.v === 't' ? words : number(data[own.dataset.v][place], +own.dataset.d || 0);
      });
      all(box, '[data-p]').forEach(function (own) {
        var names = own.dataset.p.split(','), x = data[names[0]][place], y = data[names[1]][place];
        own.style.display = x === null ? 'none' : 'block';
        if (x !== null) {
          var frame = own.parentElement.querySelector('.fr');
          own.style.left = frame.offsetLeft + x / 100 * frame.offsetWidth + 'px';
          own.style.top = frame.offsetTop + y / 100 * frame.offsetHeight + 'px';
        }
      });
    }
    function zoom(from, to) {
      var least = 1 / 400;
      from = Math.max(0, from); to = Math.min(1, to);
      if (to - from < least) { var middle = (from + to) / 2; from = Math.max(0, middle - least / 2); to = Math.min(1, from + least); }
      a = from; b = to;
      var whole = a <= 0 && b >= 1, last = frames[frames.length - 1];
      box.classList.toggle('zoomed', !whole);
      box.style.setProperty('--za', a); box.style.setProperty('--zw', b - a);
      frames.forEach(function (frame) {
        frame.querySelector('svg').setAttribute('viewBox', 4000 * a + ' 0 ' + 4000 * (b - a) + ' 1000');
        all(frame, '.g.gx').forEach(function (own) { own.style.display = whole ? '' : 'none'; });
        all(frame, '.iv').forEach(function (own) {
          var l = +own.style.getPropertyValue('--l'), w = +own.style.getPropertyValue('--w');
          var from = Math.max(l, a), to = Math.min(l + w, b);
          own.style.left = (from - a) / (b - a) * 100 + '%'; own.style.width = Math.max(to - from, 0) / (b - a) * 100 + '%';
        });
      });
      all(last, '.xt').forEach(function (own) { own.remove(); });
      if (whole) { last.insertAdjacentHTML('beforeend', ticks); show(place); return; }
      var low = lo + a * (hi - lo), high = lo + b * (hi - lo), s = step((high - low) / 6), digits = Math.max(0, Math.ceil(-Math.log10(s) - 1e-9));
      if (Math.abs(s * Math.pow(10, digits) % 1) > 1e-6) digits += 1;
      var values = [];
      for (var v = Math.ceil(low / s - 1e-9) * s; v <= high + 1e-9 * s; v += s) values.push(v);
      values.forEach(function (v, i) {
        var word = document.createElement('span');
        word.className = 'xt'; word.style.left = (v - low) / (high - low) * 100 + '%';
        word.textContent = number(v, digits) + (i === values.length - 1 && unit ? ' ' + unit : '');
        last.appendChild(word);
      });
      show(place);
    }
    function share(frame, event) {
      var own = frame.getBoundingClientRect();
      return a + Math.max(0, Math.min(1, (event.clientX - own.left) / own.width)) * (b - a);
    }
    frames.forEach(function (frame) {
      var from = null, mark = null;
      frame.addEventListener('pointerdown', function (event) {
        if (event.pointerType === 'touch') return;
        from = share(frame, event); mark = document.createElement('i'); mark.className = 'sel'; frame.appendChild(mark);
        event.preventDefault();
      });
      frame.addEventListener('pointermove', function (event) {
        var now = share(frame, event), x = lo + now * (hi - lo), p = 0, q = t.length - 1;
        while (p < q) { var m = (p + q) >> 1; if (t[m] < x) p = m + 1; else q = m; }
        if (p && x - t[p - 1] < t[p] - x) p--;
        show(p);
        if (mark) {
          var l = (Math.min(from, now) - a) / (b - a), w = Math.abs(now - from) / (b - a);
          mark.style.left = 100 * l + '%'; mark.style.width = 100 * w + '%';
        }
      });
      function up(event) {
        if (!mark) return;
        var to = share(frame, event), first = Math.min(from, to), last = Math.max(from, to);
        mark.remove(); mark = null; from = null;
        if (last - first > 0.01 * (b - a)) zoom(first, last);
      }
      frame.addEventListener('pointerup', up);
      frame.addEventListener('pointerleave', up);
      frame.addEventListener('dblclick', function () { zoom(0, 1); });
    });
    if (box.dataset.at && t.length) {
      var nearest = 0;
      t.forEach(function (own, i) { if (Math.abs(own - box.dataset.at) < Math.abs(t[nearest] - box.dataset.at)) nearest = i; });
      show(nearest);
      addEventListener('resize', function () { show(place); });
    }
    input.oninput = function () { show(+input.value); };
    input.onfocus = function () { show(place || t.length >> 1); };
    all(box, '[data-zoom]').forEach(function (own) {
      own.onclick = function () {
        var centre = t.length ? (t[place] - lo) / (hi - lo) : 0.5, half = (b - a) / 2;
        if (centre < a || centre > b || !box.classList.contains('on')) centre = (a + b) / 2;
        if (own.dataset.zoom === 'all') zoom(0, 1);
        else { half *= own.dataset.zoom === 'in' ? 0.5 : 2; zoom(centre - half, centre + half); }
      };
    });
    all(box, '[data-shade]').forEach(function (own) {
      own.onclick = function () {
        box.dataset.sel = own.dataset.shade;
        all(box, '[data-shade]').forEach(function (other) { other.setAttribute('aria-pressed', other === own); });
      };
    });
  }
  all(document, '[data-cursor]').forEach(group);

  // Causes as switches: the numbers with those that are on.
  all(document, '[data-causes]').forEach(function (box) {
    var told = JSON.parse(document.getElementById('answer').textContent).explanation, boxes = all(box, '[data-cause]');
    function show() {
      var off = boxes.filter(function (own) { return !own.checked; });
      function now(i) {
        if (!off.length) return told.numbers[i].after_m;
        return boxes.reduce(function (sum, own) {
          return sum + (own.checked ? told.causes[+own.dataset.cause].changes_m[i] : 0);
        }, told.numbers[i].before_m);
      }
      all(box, '[data-after]').forEach(function (own) { own.textContent = number(now(+own.dataset.after), 3); });
      all(box, '[data-place]').forEach(function (own) {
        var cm = 100 * (now(+own.dataset.place) - told.numbers[+own.dataset.place].printed_m), lo = +own.dataset.low, hi = +own.dataset.high;
        own.querySelector('.e').style.left = 100 * Math.max(0, Math.min(1, (cm - lo) / (hi - lo))) + '%';
      });
    }
    boxes.forEach(function (own) { own.onchange = show; });
  });
})();
