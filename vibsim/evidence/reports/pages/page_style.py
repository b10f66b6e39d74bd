"""How the HTML report looks: one readable column, light and dark, and on paper."""

STYLE = """\
:root {
  --ink: #1b1d20; --soft: #565b63; --line: #d9dce1; --ground: #ffffff; --card: #f5f6f8; --link: #005a9c;
  --yes: #0b6b3a; --if: #8a5a00; --no: #a3221b; --open: #565b63;
}
@media (prefers-color-scheme: dark) {
  :root {
    --ink: #e6e7ea; --soft: #a8adb6; --line: #3a3f47; --ground: #16181b; --card: #1f2226; --link: #7fbcf0;
    --yes: #63c78f; --if: #e0b050; --no: #f08a80; --open: #a8adb6;
  }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; padding: 2.5rem 1.25rem 4rem; max-width: 62rem;
  color: var(--ink); background: var(--ground);
  font: 1rem/1.55 system-ui, -apple-system, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif;
}
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.35rem; margin: 3rem 0 1rem; padding-bottom: .3rem; border-bottom: 1px solid var(--line); }
h3 { font-size: 1.05rem; line-height: 1.35; margin: 0 0 .4rem; }
h3 small { font-weight: normal; color: var(--soft); }
a { color: var(--link); }
p { max-width: 46rem; }
header p { color: var(--soft); }
nav ul { display: flex; flex-wrap: wrap; gap: .3rem 1.25rem; padding: 0; margin: 1rem 0 0; list-style: none; }
.skip { position: absolute; left: -100rem; }
.skip:focus { left: 1rem; top: 1rem; background: var(--ground); padding: .5rem; }
article {
  margin: 1.1rem 0; padding: 1rem 1.2rem; background: var(--card);
  border: 1px solid var(--line); border-radius: 6px;
  break-inside: avoid;
}
blockquote { margin: 0 0 .5rem; padding-left: .8rem; border-left: 3px solid var(--line); }
blockquote p { margin: 0; max-width: none; font-style: italic; }
q { quotes: "\\201C" "\\201D"; }
cite { font-style: normal; color: var(--soft); font-size: .9rem; white-space: nowrap; }
cite::before { content: "· "; }
.said { margin: 1.2rem 0; }
.said > p { margin: 0; }
article figure { margin: 1.2rem 0 0; }
.finding { margin: .3rem 0 .8rem; max-width: none; }
.verdict { font-weight: 600; white-space: nowrap; border-bottom: 2px solid currentColor; }
.v0 { color: var(--yes); } .v1, .v2, .v3 { color: var(--if); } .v4 { color: var(--no); }
.v5, .v6 { color: var(--open); }
article dl, footer dl { display: grid; grid-template-columns: 6.2rem 1fr; gap: .35rem .8rem; margin: 0; }
dt { color: var(--soft); font-size: .9rem; }
dd { margin: 0; font-size: .95rem; overflow-wrap: anywhere; }
dd ul { margin: 0; padding-left: 1.1rem; }
.wide { overflow-x: auto; margin: 1.2rem 0; }
table { border-collapse: collapse; font-size: .92rem; font-variant-numeric: tabular-nums; min-width: 60%; }
caption { text-align: left; color: var(--soft); padding-bottom: .4rem; }
th, td {
  text-align: left; vertical-align: top; padding: .35rem .9rem .35rem 0; border-bottom: 1px solid var(--line);
}
thead th { font-weight: 600; border-bottom: 2px solid var(--line); }
tbody th { font-weight: 500; }
figure { margin: 1.8rem 0 2.4rem; break-inside: avoid; }
figure img {
  display: block; width: 100%; height: auto; background: #ffffff; padding: .5rem;
  border: 1px solid var(--line); border-radius: 6px;
}
figcaption { margin-top: .5rem; font-size: .92rem; color: var(--soft); max-width: 50rem; }
figcaption b { color: var(--ink); }
footer { margin-top: 3.5rem; padding-top: 1rem; border-top: 1px solid var(--line); color: var(--soft); }
@media (max-width: 40rem) {
  table.many { min-width: 42rem; }
  article dl, footer dl { grid-template-columns: 1fr; gap: .1rem; }
  dd { margin-bottom: .5rem; }
}
@media print {
  :root {
    --ink: #000; --soft: #333; --line: #bbb; --ground: #fff; --card: #fff;
    --yes: #000; --if: #000; --no: #000; --open: #000;
  }
  body { max-width: none; padding: 0; font-size: 10pt; }
  nav, .skip { display: none; }
  h2 { break-after: avoid; }
  .wide { overflow: visible; }
}
"""
