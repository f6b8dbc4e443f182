// Looks for what is wrong with a page: returns the number of charts and a list of problems.
(() => {
    const problems = [];
    const say = (what) => { if (problems.length < 40) problems.push(what); };
    const all = (what, where = document) => [...where.querySelectorAll(what)];
    const seen = (element) => {
        const box = element.getBoundingClientRect();
        return box.width > 0 && box.height > 0 && element.checkVisibility({ visibilityProperty: true });
    };
    const short = (element) => element.textContent.trim().slice(0, 30);
    const overlap = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
        && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
    const pairs = (elements) => {
        const boxes = elements.filter(seen).map((e) => ({ text: short(e), box: e.getBoundingClientRect(), e }));
        boxes.forEach((one, i) => boxes.slice(i + 1).forEach((other) => {
            if (!one.e.contains(other.e) && !other.e.contains(one.e) && overlap(one.box, other.box))
                say(`'${one.text}' over '${other.text}'`);
        }));
    };

    // Charts: described, large enough, with marks and ticks; words neither cut off nor over each other.
    const frames = all('.fr').filter(seen);
    for (const [i, frame] of frames.entries()) {
        const box = frame.getBoundingClientRect();
        if (!frame.getAttribute('aria-label')) say(`chart ${i} has no description`);
        if (box.width < 120 || box.height < 20) say(`chart ${i} is tiny: ${box.width} x ${box.height}`);
        if (!all('path:not(.g):not(.z)', frame).some((p) => (p.getAttribute('d') || '').length > 5))
            say(`chart ${i} shows nothing`);
        const words = all('.yt, .xt, .dl', frame).filter(seen);
        pairs(words);
        for (const word of words) {
            const own = word.getBoundingClientRect();
            if (own.left < -1 || own.right > innerWidth + 1) say(`chart ${i}: '${short(word)}' is cut off`);
        }
    }

    // Blocks of text over each other; text wider than what it stands in.
    pairs(all('h1, h2, h3, .lead, .sub, .row-h, .fr, .labs, .tw, .box, .cmd, .note, .key, .legend, figcaption, .zoom'));
    all('td, th').filter(seen).forEach((cell) => {
        if (cell.scrollWidth > cell.clientWidth + 1) say(`'${short(cell)}' is wider than its cell`);
    });
    if (document.documentElement.scrollWidth > innerWidth) say(`the page is too wide: ${document.documentElement.scrollWidth}`);

    // Contrast of 4.5 : 1 for every text.
    const parse = (colour) => (colour.match(/[\d.]+/g) || []).map(Number);
    const light = (c) => {
        const [r, g, b] = c.slice(0, 3).map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const ground = (element) => {
        for (let own = element; own; own = own.parentElement) {
            const c = parse(getComputedStyle(own).backgroundColor);
            if (c.length === 3 || c[3] === 1) return c;
        }
        return [255, 255, 255];
    };
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
        const own = node.parentElement;
        if (!node.textContent.trim() || !seen(own) || ['SCRIPT', 'STYLE'].includes(own.tagName) || own.closest('.sr, .sq')) continue;
        const [a, b] = [light(parse(getComputedStyle(own).color)), light(ground(own))].sort((x, y) => y - x);
        if ((a + 0.05) / (b + 0.05) < 4.5) say(`too little contrast: '${short(own)}' ${((a + 0.05) / (b + 0.05)).toFixed(2)}`);
    }

    // Names for programs that read pages aloud.
    all('button, input, a').forEach((own) => {
        if (!own.textContent.trim() && !own.getAttribute('aria-label')) say(`a ${own.tagName} without a name`);
    });
    all('[role=img]').forEach((own) => { if (!own.getAttribute('aria-label')) say('an image without a name'); });
    const levels = all('h1, h2, h3').map((own) => +own.tagName[1]);
    if (levels.filter((level) => level === 1).length !== 1) say('not one h1');
    levels.forEach((level, i) => { if (i && level > levels[i - 1] + 1) say('a heading leaves a level out'); });
    const ids = all('[id]').map((own) => own.id);
    if (new Set(ids).size !== ids.length) say('an id stands twice');
    if (!document.documentElement.lang || !document.title) say('no language or title');
    return { charts: frames.length, problems };
})()
