// Faults that are planted in a page, each with a word of the complaint that it has to bring.

const script = code => text => text.replace("</body>", `<script>${code}</script></body>`);
const style = rule => text => text.replace("</style>", `${rule}</style>`);
const phone = { width: 390 };

const FAULTS = [
  { name: "a script error", plant: script("undefinedName();"), complaint: "script error" },
  { name: "a message on the console", plant: script("console.warn('odd')"), complaint: "console, warn" },
  {
    name: "a picture from elsewhere",
    plant: text => text.replace(/<meta http-equiv[^>]*>/, "").replace("<h1>", "<img src=\"other.png\" alt=\"x\"><h1>"),
    complaint: "loads file:",
  },
  { name: "too wide for a phone", plant: style("main{min-width:500px}"), complaint: "wide on a screen", view: phone },
  { name: "tables that do not scroll", plant: style(".scroll{overflow:visible}"), complaint: "wide on a screen", view: phone },
  { name: "no plots", plant: text => text.replace(/<svg[\s\S]*?<\/svg>/g, ""), complaint: "plots are seen" },
  { name: "both sizes of a plot", plant: style(".narrow{display:block}"), complaint: "2 plots" },
  {
    name: "letters of plots black in the dark",
    plant: style("figure svg text{fill:#000 !important}"),
    complaint: "letters with a contrast",
    view: { scheme: "dark" },
  },
  {
    name: "letters over each other",
    plant: text => text.replace(/<text x="\d+" y="\d+"/g, '<text x="150" y="90"'),
    complaint: "letters over each other",
  },
  { name: "small letters", plant: style("figure svg text{font-size:5px}"), complaint: " high: " },
  { name: "headers that do nothing", plant: text => text.replace("const order =", "return; const order ="), complaint: "not sorted" },
  { name: "rows that stay", plant: text => text.replace("body.append(", "void ("), complaint: "out of order" },
];

const SLIDER_FAULTS = [
  { name: "a slider that does nothing", plant: text => text.replace('"input", show', '"input", null'), complaint: "slider, Home" },
  { name: "no dragging", plant: text => text.replace('"pointermove"', '"pointernever"'), complaint: "slider, dragged" },
  { name: "pictures beside each other", plant: style(".frame .above{width:90%}"), complaint: "do not cover" },
];

const LEGEND_FAULTS = [
  {
    name: "curves that look alike",
    plant: text => text.replaceAll(/color:var\(--c\d\)/g, "color:var(--c0)").replaceAll("swatch hollow", "swatch"),
    complaint: "look like another one",
  },
];

const SCALE_FAULTS = [
  { name: "heat maps without colours", plant: text => text.replaceAll(/color:#[0-9a-f]{6}/g, "color:#777777"), complaint: "look alike in its legend" },
  { name: "a heat map without a legend", plant: text => text.replace(/<ul class="legend scale">[\s\S]*?<\/ul>/, ""), complaint: "legends" },
];

/** Those that can be planted in this page. */
export function faultsOf(text) {
  const slider = text.includes("figure class=\"picture wipe\"") ? SLIDER_FAULTS : [];
  const scale = text.includes("ul class=\"legend scale\"") ? SCALE_FAULTS : [];
  return [...FAULTS, ...slider, ...scale, ...(text.includes("ul class=\"legend\"") ? LEGEND_FAULTS : [])];
}
