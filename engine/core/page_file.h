// page_file.h - memory that can leave the process for a file, and comes back when it is touched: pointers into it stay as they are.
//
// Pieces are ordinary memory until page_file_drop. So what is taken and given back between two calls never meets the disk. The file has no
// name: nothing is left behind, however the program ends. Any thread may call these functions.
#ifndef CORE_PAGE_FILE_H
#define CORE_PAGE_FILE_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/error.h"

typedef struct PageFile PageFile;

// A new file, which is empty, in the folder. NULL where it cannot be made.
PageFile *page_file_new(const char *folder, Error *error);
void page_file_free(PageFile *file);  // all of its memory is gone; NULL is allowed

// Zeroed memory, in whole pages and aligned to them. NULL: there is none, or no more addresses.
void *page_file_take(PageFile *file, size_t bytes);
void page_file_give(void *memory);  // back to its file
// The file of a piece that was taken, NULL: it is not of one. Its size, bytes.
PageFile *page_file_of(const void *memory);
size_t page_file_size(const void *memory);

// The bytes that are taken now.
size_t page_file_used(PageFile *file);
// All that is taken lies in the file from now on, and no page of it is in the process, until one is touched. Room on the disk is taken
// before a page is written. False, with a sentence, where there is too little: what has no room there stays in the process.
bool page_file_drop(PageFile *file, Error *error);
// A mark for those who count what is in use: is nobody at work on it?
void page_file_set_asleep(PageFile *file, bool asleep);
bool page_file_asleep(PageFile *file);

#endif
