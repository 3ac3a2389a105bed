/* SPDX-License-Identifier: BSD-3-Clause */
/* One line per event on standard error, for the journal or a terminal. Only run, net and the programs log. */
#ifndef BASE_LOG_H
#define BASE_LOG_H

/* Levels as in syslog: a smaller number is more urgent. */
typedef enum LogLevel { LOG_ERROR = 3, LOG_WARNING = 4, LOG_NOTICE = 5, LOG_INFORMATION = 6, LOG_DETAIL = 7 } LogLevel;

/* Whom people called, which is who speaks to them: the name borrowed for good, "meniscusd" if nobody says otherwise. Before there are threads. */
void log_set_program(const char *name);
const char *log_program(void);

/* Lines of a higher number than level are not written; at the start that is LOG_INFORMATION. */
void log_set_level(LogLevel level);

/* Level of "error", "warning", "notice", "info" or "debug"; -1 for any other word. */
int log_level_find(const char *word);

/* The one that is set. */
LogLevel log_level(void);

/* Write one line; any thread may, and none waits: what nobody reads is lost, and counted for who reads on. Control characters become
 * blanks, so that no text from outside forges a line. */
void log_line(LogLevel level, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
