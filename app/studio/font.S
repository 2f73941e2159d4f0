// SPDX-License-Identifier: MIT
// The interface's letters as bytes of the program: AIRCLAY_FONT is the typeface's file (third_party/README.md).
    .section .rodata
    .global airclay_font
    .global airclay_font_end
    .balign 16
airclay_font:
    .incbin AIRCLAY_FONT
airclay_font_end:
    .byte 0
    .section .note.GNU-stack, "", %progbits
