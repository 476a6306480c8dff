// page_file.h - memory that lies in a file: its pages leave the process while nobody needs them, and pointers into it stay as they are.
//
// The file has no name, so nothing is left behind, however the program ends. Its room on the disk is taken before a page is written: a full
// disk is told when memory is asked for. Any thread may call these functions.
#ifndef CORE_PAGE_FILE_H
#define CORE_PAGE_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/error.h"

typedef struct PageFile PageFile;

// A new file, which is empty, in the folder. NULL where it cannot be made.
PageFile *page_file_new(const char *folder, Error *error);
void page_file_free(PageFile *file);  // all of its memory is gone; NULL is allowed

// Zeroed memory, in whole pages and aligned to them. NULL: there is no room on the disk or for addresses.
void *page_file_take(PageFile *file, size_t bytes);
void page_file_give(void *memory);  // back to its file
// The file of a piece that was taken, NULL: it is not of one. Its size, bytes.
PageFile *page_file_of(const void *memory);
size_t page_file_size(const void *memory);

// The bytes that are taken now.
size_t page_file_used(PageFile *file);
// No page of it is in the process any more, until one is touched; gaps give their room on the disk back.
void page_file_drop(PageFile *file);
// A mark for those who count what is in use: is nobody at work on it?
void page_file_set_asleep(PageFile *file, bool asleep);
bool page_file_asleep(PageFile *file);

#endif
