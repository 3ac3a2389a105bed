/* SPDX-License-Identifier: BSD-3-Clause */
/* What tests say to a daemon, in one call each, and what they look for in the answer. All fail the test that finds otherwise;
 * replies are freed with meniscus__reply__free_unpacked() unless the function takes them. */
#ifndef TESTS_STEER_H
#define TESTS_STEER_H

#include "tests/support/dialogue.h"

/* For cmocka: a daemon of its own for each test, which must end well. */
int steer_begin(void **state);
int steer_end(void **state);

/* The same, but the test has ended it or may leave it in any state. */
int steer_end_somehow(void **state);

/* Seconds since some moment; sleep. */
double steer_now(void);
void steer_sleep(long milliseconds);

/* Where the daemon keeps its runs: "HOME/state/NAME". */
void steer_path(const Dialogue *dialogue, const char *name, char ret[static 256]);

/* Load the small dam break with these changes, and say where its run is: "HOME/state/dam". */
void steer_load_here(Dialogue *dialogue, const char *const *settings, char ret_here[static 256]);

/* Rename the directory of that run, as if it had gone; give it back. */
void steer_take_away(const Dialogue *dialogue);
void steer_bring_back(const Dialogue *dialogue);

/* How many entries of a directory begin like this, those that are being written aside. */
int steer_count(const char *directory, const char *like);

Meniscus__Code steer_code(Dialogue *dialogue, Meniscus__Request request);
Meniscus__Reply *steer_status(Dialogue *dialogue);
Meniscus__Reply *steer_step(Dialogue *dialogue, uint64_t n);
Meniscus__Reply *steer_until(Dialogue *dialogue, double t);
Meniscus__Reply *steer_set(Dialogue *dialogue, const char *path, const char *value);
/* With all that `under` has but a command: a lease, a version, a step at which it is to be done. */
Meniscus__Reply *steer_set_under(Dialogue *dialogue, const Meniscus__Request *under, const char *path,
                                 const char *value);

/* Ask for something long on a connection, under an id [16], and do not wait: to run to a time, to wait for a step or a state. */
void steer_say_until(void *socket, double t, uint8_t *id);
void steer_say_wait(void *socket, uint64_t step, uint8_t *id);
void steer_say_wait_for(void *socket, Meniscus__State state, uint8_t *id);

/* Set n entries at once; and the same without waiting for the reply. */
Meniscus__Code steer_set_all(Dialogue *dialogue, size_t n, const char *const (*pairs)[2]);
void steer_say_set(void *socket, size_t n, const char *const (*pairs)[2], uint8_t *id);

Meniscus__Reply *steer_restore(Dialogue *dialogue, const char *checkpoint); /* NULL: the newest */
Meniscus__Reply *steer_wait(Dialogue *dialogue, Meniscus__State state, long patience_ms);
Meniscus__Reply *steer_wait_step(Dialogue *dialogue, uint64_t step);

/* Take a reply: it must be OK; it must be refused with a sentence that has this in it. */
void steer_accepted(Meniscus__Reply *reply);
void steer_refused(Meniscus__Reply *reply, Meniscus__Code code, const char *part);

/* So many steps, done. */
void steer_go(Dialogue *dialogue, uint64_t n);

/* The step it is at, standing or not. */
uint64_t steer_step_now(Dialogue *dialogue);

void steer_stands_at(Dialogue *dialogue, Meniscus__State state, uint64_t step);

/* Wait for the state, 15 s at most. */
void steer_wait_for(Dialogue *dialogue, Meniscus__State state);

/* The state's hash, when it stands still. */
uint64_t steer_hash(Dialogue *dialogue);

/* A number of the case. */
double steer_get(Dialogue *dialogue, const char *path);

/* Have a checkpoint written; where it is. */
void steer_write_checkpoint(Dialogue *dialogue, char path[static 256]);

/* Telemetry of a topic; close it with zmq_close(). */
void *steer_subscribe(Dialogue *dialogue, const char *topic);

/* The next message within five seconds; freed with meniscus__telemetry__free_unpacked(). */
Meniscus__Telemetry *steer_hear(void *socket);

/* Listen to "log" until there is a line with this in it. */
void steer_hear_of(void *log, const char *part);

#endif
