"use strict";
(() => {
  const rows = JSON.parse(document.getElementById("rows").textContent);
  const get = (name) => document.getElementById(name);
  const cards = get("cards");
  const step = 60; // cards that are added at a time: a screen or two
  const ranks = { failed: 0, foreign: 1, doubtful: 2, good: 3 };
  const byName = new Intl.Collator(undefined, { numeric: true }).compare;
  const unknownLast = (key, sign) => (a, b) => {
    if (a[key] === null || b[key] === null) return (a[key] === null) - (b[key] === null);
    return sign * (a[key] - b[key]);
  };
  const orders = {
    name: () => 0,
    status: (a, b) => ranks[a.status] - ranks[b.status],
    chance: unknownLast("chance", 1),
    error: unknownLast("error", -1),
    area: unknownLast("area", 1),
    full: (a, b) => byName(a.full, b.full),
  };
  let chosen = [];
  let drawn = 0;

  const element = (kind, name, text) => {
    const made = document.createElement(kind);
    made.className = name;
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const percent = (value) => (value === null ? "unknown" : `${(100 * value).toFixed(0)} %`);

  function card(row) {
    const item = document.createElement("li");
    const box = element(row.link ? "a" : "div", "card");
    if (row.link) box.href = row.link;
    const picture = element("div", "picture");
    if (row.picture) {
      const image = document.createElement("img");
      image.alt = "";
      image.loading = "lazy";
      image.decoding = "async";
      image.src = row.picture;
      picture.append(image);
    } else {
      picture.append(element("span", "", "no picture"));
    }
    const words = element("div", "words");
    words.append(element("div", "name", row.name));
    const status = element("div", `status ${row.status}`, row.status);
    if (row.full) status.append(element("span", "facts", ` on ${row.full}`));
    words.append(status);
    if (row.status !== "failed") {
      const said = [`chance ${percent(row.chance)}`, `error estimate ${percent(row.error)}`];
      if (row.area !== null) said.push(`${(100 * row.area).toFixed(0)} % of the area`);
      words.append(element("div", "facts", said.join(" · ")));
    }
    if (row.status !== "good") {
      const reason = element("div", "reason", row.reason);
      reason.title = row.reason;
      words.append(reason);
    }
    box.append(picture, words);
    item.append(box);
    return item;
  }

  function more() {
    const next = chosen.slice(drawn, drawn + step);
    cards.append(...next.map(card));
    drawn += next.length;
  }

  function remember() {
    const state = new URLSearchParams();
    for (const name of ["text", "status", "order"]) {
      if (get(name).value) state.set(name, get(name).value);
    }
    if (get("reverse").checked) state.set("reverse", "1");
    history.replaceState(null, "", `#${state}`);
  }

  function show() {
    const words = get("text").value.toLowerCase().split(/\s+/).filter(Boolean);
    const status = get("status").value;
    chosen = rows.filter((row) => {
      if (status && row.status !== status) return false;
      const said = `${row.name} ${row.full} ${row.reason}`.toLowerCase();
      return words.every((word) => said.includes(word));
    });
    const order = orders[get("order").value];
    chosen.sort((a, b) => order(a, b) || byName(a.name, b.name));
    if (get("reverse").checked) chosen.reverse();
    cards.replaceChildren();
    drawn = 0;
    more();
    get("nothing").hidden = chosen.length > 0;
    get("shown").textContent = `${chosen.length} of ${rows.length} parts`;
  }

  function recall() {
    const state = new URLSearchParams(location.hash.slice(1));
    for (const name of ["text", "status", "order"]) {
      if (state.has(name)) get(name).value = state.get(name);
    }
    get("reverse").checked = state.has("reverse");
  }

  const counts = {};
  for (const row of rows) counts[row.status] = (counts[row.status] || 0) + 1;
  get("counts").textContent = Object.keys(ranks)
    .reverse()
    .filter((status) => counts[status])
    .map((status) => `${counts[status]} ${status}`)
    .join(", ");
  recall();
  show();
  document.querySelector("form").addEventListener("input", () => {
    remember();
    show();
  });
  document.querySelector("form").addEventListener("submit", (event) => event.preventDefault());
  new IntersectionObserver((seen) => {
    if (seen.some((each) => each.isIntersecting) && drawn < chosen.length) more();
  }, { rootMargin: "800px" }).observe(get("end"));
})();
