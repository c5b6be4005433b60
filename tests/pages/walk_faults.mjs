// Faults that are planted in a page to walk through, each with a word of the complaint that it has to bring.

const swap = (what, other) => text => text.replace(what, other);
const script = code => swap("</body>", `<script>${code}</script></body>`);

export const WALK_FAULTS = [
  { name: "a script error", plant: script("undefinedName();"), complaint: "script error" },
  { name: "a message on the console", plant: script("console.warn('odd')"), complaint: "console, warn" },
  {
    name: "something from elsewhere",
    plant: text => text.replace(/<meta http-equiv[^>]*>/, "").replace("</body>", "<img src=\"other.png\" alt=\"x\"></body>"),
    complaint: "loads file:",
  },
  { name: "a damaged part", plant: swap(/data-vertices="(\d+)"/, "data-vertices=\"1\""), complaint: "damaged" },
  { name: "a page that was cut off", plant: text => text.slice(0, text.length / 2), complaint: "cut off" },
  { name: "light a tenth darker", plant: swap("max(radiance, 0.0) * exposure", "max(radiance, 0.0) * 0.9 * exposure"), complaint: "filmic: differs" },
  { name: "another tone curve", plant: swap("KNEE = 0.45", "KNEE = 0.1"), complaint: "filmic: differs" },
  { name: "a gamma of 2.2", plant: swap("1.0 / 2.4", "1.0 / 2.2"), complaint: "filmic: differs" },
  { name: "a wider lens", plant: swap("lens.vfov * Math.PI / 360", "lens.vfov * Math.PI / 350"), complaint: "filmic: differs" },
  { name: "the other side of surfaces", plant: swap("three.FrontSide", "three.BackSide"), complaint: "filmic: differs" },
  { name: "light of 8 bits", plant: swap("radiance = light.rgb;", "radiance = min(light.rgb, 1.0);"), complaint: "dim: differs" },
  { name: "an exposure that stays", plant: swap("uniforms.exposure.value = 2 ** value", "uniforms.exposure.value = 1"), complaint: "plain: differs" },
  { name: "no mesh", plant: swap("if (mesh) {", "if (false) {"), complaint: "element mesh: the picture stays" },
  { name: "other classes", plant: swap("colours[int(mark + 0.5) - 1]", "colours[3 - (int(mark + 0.5) - 1)]"), complaint: "class: differs" },
  { name: "keys that do nothing", plant: swap("walker.held.add(event.code);", ""), complaint: "fly, w: the picture stays" },
  { name: "no dragging", plant: swap('"pointermove"', '"pointernever"'), complaint: "orbit, dragged" },
  { name: "one camera", plant: swap("lens = settings.cameras[index];", "index = 0; lens = settings.cameras[0];"), complaint: "second: differs" },
  { name: "out of reach of the keyboard", plant: swap("<select id=\"camera\"", "<select tabindex=\"-1\" id=\"camera\""), complaint: "not reached by keyboard: camera" },
  { name: "too wide for a phone", plant: swap("</style>", "#panel[open]{min-width:450px}</style>"), complaint: "out of the screen", isOfLayout: true },
  { name: "too low for a phone held sideways", plant: swap(" || innerHeight <= 480", ""), complaint: "held sideways", isOfLayout: true },
  { name: "pale letters", plant: swap("</style>", "#panel p{color:#bbb !important}</style>"), complaint: "letters with a contrast", isOfLayout: true },
];
