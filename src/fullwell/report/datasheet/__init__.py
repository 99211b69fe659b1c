"""The EMVA 1288 datasheet: cover, general page, a summary page per operation point and channel, detail pages.

`contents` is what a datasheet holds, `build` makes it from results, `pdf` sets it in type; the chapter of report.html
shows the same contents.
"""
