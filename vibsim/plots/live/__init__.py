"""Pages that answer: one HTML file that needs no network, with zoom, hover and linked panels.

The scripts are plain JavaScript on a canvas: `axes.js` for every page, `run.js` for runs, `points.js` for
tables of points, with `lines.js` where these lie on a curve, `animate.js` for moving machines.
"""
