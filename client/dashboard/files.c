/* SPDX-License-Identifier: BSD-3-Clause */
/* The front end. The linker makes objects of its files and names them so: see `dashboard` in the Makefile. */
#include "client/dashboard/files.h"
#include <stdint.h>
#include <string.h>

#define EMBEDDED(name) extern const unsigned char _binary_##name##_start[], _binary_##name##_end[]
EMBEDDED(index_html);
EMBEDDED(app_js);
EMBEDDED(app_css);
EMBEDDED(icon_svg);

const File *file_find(const char *path)
{
    static File files[] = {
        {"/", "text/html; charset=utf-8", _binary_index_html_start, 0},
        {"/app.js", "text/javascript; charset=utf-8", _binary_app_js_start, 0},
        {"/app.css", "text/css; charset=utf-8", _binary_app_css_start, 0},
        {"/icon.svg", "image/svg+xml", _binary_icon_svg_start, 0},
    };
    /* Such addresses are known to the linker, not to the compiler. */
    files[0].size = (uintptr_t)_binary_index_html_end - (uintptr_t)_binary_index_html_start;
    files[1].size = (uintptr_t)_binary_app_js_end - (uintptr_t)_binary_app_js_start;
    files[2].size = (uintptr_t)_binary_app_css_end - (uintptr_t)_binary_app_css_start;
    files[3].size = (uintptr_t)_binary_icon_svg_end - (uintptr_t)_binary_icon_svg_start;
    for (size_t k = 0; k < sizeof files / sizeof *files; k++)
        if (!strcmp(files[k].path, path)) return &files[k];
    return NULL;
}
