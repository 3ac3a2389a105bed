/* SPDX-License-Identifier: BSD-3-Clause */
/* The door: who may connect, and as whom. Every connection passes it before it gets or says anything: those from this machine have
 * the user "local", an admin, as only its user can open the sockets; those from afar are known by their keys. They pass a door twice: that of the gate,
 * where they prove that they have the key (CURVE), and that of the daemon, where the gate says whose it is (PLAIN). ZeroMQ asks here
 * (ZAP, RFC 27) and notes the answer with each message. To be made before any other socket, and used by
 * one thread, but for access_who(). */
#ifndef NET_ACCESS_H
#define NET_ACCESS_H

#include "common/wire/keys.h"
#include "run/order.h"
#include <zmq.h>

typedef struct Access Access;

/* keys: directory of those who are let in from afar; empty or NULL: nobody is. tells: it logs how many they are, and what is wrong with the
 * file. MNS_E_NOT_FOUND if there is no key of the daemon there, MNS_E_STATE if others could read it; MNS_E_INVALID, MNS_E_IO, MNS_E_MEMORY. */
MnsStatus access_new(void *context, const char *keys, bool tells, Access **ret, MnsError *error);
void access_free(Access *access);

/* Whatever the socket binds from now on is for this machine; for the gate; for those who have a key, whose every byte is encrypted. */
void access_guard_local(const Access *access, void *socket);
void access_guard_gate(const Access *access, void *socket);
void access_guard_remote(const Access *access, void *socket);

/* Where to wait for news: a socket of ZeroMQ, and a file descriptor, or -1. */
void *access_socket(const Access *access);
int access_watch(const Access *access);

/* Answer one who wants to connect. False if there is none now. */
bool access_answer(Access *access);

/* The socket is to connect as who has this key, to what is guarded for the gate. */
void access_introduce(void *socket, const char *public_key);

/* Look whether the file of keys has changed, and take it as it is now. True if a key is gone: then connections from afar must be
 * cut, as whoever had it may have one. A file that is wrong, or that others could change, lets nobody in. */
bool access_refresh(Access *access);

/* How many keys of a role are let in. */
size_t access_count(const Access *access, Role role);

/* Who sent this frame, one of the envelope and not that of the connection's id. False if that is nobody who is let in. Any thread. */
bool access_who(Access *access, zmq_msg_t *frame, Who *ret);

#endif
