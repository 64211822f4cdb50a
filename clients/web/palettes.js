// The palettes of the radar picture, the same table as radar_service/display/palettes.py, which explains it (a test compares
// them). A stop is a level, 0 to 255, and the colour of echoes of that level; level 0 is the sea. The value is plain JSON.

export const PALETTES = {
  "multicolour": [
    [0, "#04121d"], [1, "#0c2a50"], [12, "#2468b4"], [28, "#2080b4"], [48, "#1f9894"],
    [70, "#44ae66"], [92, "#88b83a"], [122, "#c8c02a"], [180, "#f2da58"], [255, "#ffffd0"]
  ],
  "dusk": [[0, "#04121d"], [1, "#37483a"], [110, "#c8a93c"], [255, "#fff6b8"]],
  "day": [[0, "#0b2c4d"], [1, "#4d6472"], [110, "#e3cc55"], [255, "#fffbd6"]],
  "night": [[0, "#000000"], [1, "#2a1409"], [110, "#8a4a1c"], [255, "#d99a5c"]],
  "phosphor": [[0, "#010a05"], [1, "#073d1c"], [110, "#1fb95b"], [255, "#d8ffe2"]]
};
