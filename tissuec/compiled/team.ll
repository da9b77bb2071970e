; How threads share a loop; see tissuec/engine/threads.py. Words of a team, all of 64 bits:
;   0: the number of the present loop: even, and odd where threads are to end instead
;   1: what to call    2: its arguments
;   3: the number of parts    4: how many of them each thread has for its own
;  16: parts that are not done yet, or threads that have not ended yet
;  24: a function of the system that gives way, or 0
;  32 and every eighth one behind: of each part, the last loop in which a thread has taken it

; Let all threads do parts of a loop; return when all parts are done.
define void @share_loop(ptr %words, ptr %job, ptr %arguments) noinline {
  %parts.place = getelementptr i64, ptr %words, i64 3
  %parts = load i64, ptr %parts.place, align 8
  %before = load atomic i64, ptr %words monotonic, align 8
  %behind = add i64 %before, 2
  %loop = and i64 %behind, -2
  call void @announce(ptr %words, i64 %loop, i64 %parts, ptr %job, ptr %arguments)
  call void @do_parts(ptr %words, i64 0, i64 %loop, ptr %job, ptr %arguments)
  call void @wait(ptr %words)
  ret void
}

; End the other threads; return when they have ended.
define void @dismiss(ptr %words, i64 %others) {
  %before = load atomic i64, ptr %words monotonic, align 8
  %behind = add i64 %before, 1
  %loop = or i64 %behind, 1
  call void @announce(ptr %words, i64 %loop, i64 %others, ptr null, ptr null)
  call void @wait(ptr %words)
  ret void
}

; Do parts of loops after some loop until the end, as one of the other threads, from 1 on.
define void @serve(ptr %words, i64 %thread, i64 %before) {
entry:
  %job.place = getelementptr i64, ptr %words, i64 1
  %arguments.place = getelementptr i64, ptr %words, i64 2
  br label %look
look:
  %last = phi i64 [ %before, %entry ], [ %loop, %do ], [ %last, %again ]
  %turns = phi i64 [ 0, %entry ], [ 0, %do ], [ %next, %again ]
  %loop = load atomic i64, ptr %words acquire, align 8
  %same = icmp eq i64 %loop, %last
  br i1 %same, label %again, label %begun
begun:
  %odd = and i64 %loop, 1
  %ends = icmp ne i64 %odd, 0
  br i1 %ends, label %end, label %do
do:
  ; Those of a later loop, if all parts of this one are done meanwhile; then none is left to take.
  %job.word = load atomic i64, ptr %job.place monotonic, align 8
  %arguments.word = load atomic i64, ptr %arguments.place monotonic, align 8
  %job = inttoptr i64 %job.word to ptr
  %arguments = inttoptr i64 %arguments.word to ptr
  call void @do_parts(ptr %words, i64 %thread, i64 %loop, ptr %job, ptr %arguments)
  br label %look
again:
  %next = add i64 %turns, 1
  call void @take_turn(ptr %words, i64 %next)
  br label %look
end:
  %pending = getelementptr i64, ptr %words, i64 16
  %left = atomicrmw sub ptr %pending, i64 1 release, align 8
  ret void
}

; Begin a loop.
define internal void @announce(
    ptr %words, i64 %loop, i64 %pending, ptr %job, ptr %arguments) noinline {
  %job.place = getelementptr i64, ptr %words, i64 1
  %arguments.place = getelementptr i64, ptr %words, i64 2
  %pending.place = getelementptr i64, ptr %words, i64 16
  %job.word = ptrtoint ptr %job to i64
  %arguments.word = ptrtoint ptr %arguments to i64
  store atomic i64 %job.word, ptr %job.place monotonic, align 8
  store atomic i64 %arguments.word, ptr %arguments.place monotonic, align 8
  store atomic i64 %pending, ptr %pending.place monotonic, align 8
  store atomic i64 %loop, ptr %words release, align 8
  ret void
}

; Do the parts that nobody has taken, the thread's own ones first: their nodes are in its caches.
define internal void @do_parts(
    ptr %words, i64 %thread, i64 %loop, ptr %job, ptr %arguments) noinline {
entry:
  %parts.place = getelementptr i64, ptr %words, i64 3
  %own.place = getelementptr i64, ptr %words, i64 4
  %pending = getelementptr i64, ptr %words, i64 16
  %taken.place = getelementptr i64, ptr %words, i64 32
  %parts = load i64, ptr %parts.place, align 8
  %own = load i64, ptr %own.place, align 8
  %first = mul i64 %thread, %own
  br label %look
look:
  %k = phi i64 [ 0, %entry ], [ %k.next, %next ]
  %done = phi i64 [ 0, %entry ], [ %done.next, %next ]
  %open = icmp ult i64 %k, %parts
  br i1 %open, label %see, label %end
see:
  %behind = add i64 %first, %k
  %part = urem i64 %behind, %parts
  %word = mul i64 %part, 8
  %place = getelementptr i64, ptr %taken.place, i64 %word
  %taken = load atomic i64, ptr %place monotonic, align 8
  %free = icmp ult i64 %taken, %loop
  br i1 %free, label %take, label %next
take:
  ; Fails if another thread took the part, also if another loop has begun since.
  %pair = cmpxchg ptr %place, i64 %taken, i64 %loop acq_rel monotonic, align 8
  %is.own = extractvalue { i64, i1 } %pair, 1
  br i1 %is.own, label %do, label %next
do:
  call void %job(i64 %part, i64 %parts, ptr %arguments)
  %done.more = add i64 %done, 1
  br label %next
next:
  %done.next = phi i64 [ %done, %see ], [ %done, %take ], [ %done.more, %do ]
  %k.next = add i64 %k, 1
  br label %look
end:
  %some = icmp ne i64 %done, 0
  br i1 %some, label %tell, label %leave
tell:
  %left = atomicrmw sub ptr %pending, i64 %done release, align 8
  br label %leave
leave:
  ret void
}

; Wait until all parts are done.
define internal void @wait(ptr %words) noinline {
entry:
  %pending = getelementptr i64, ptr %words, i64 16
  br label %look
look:
  %turns = phi i64 [ 0, %entry ], [ %next, %again ]
  %left = load atomic i64, ptr %pending acquire, align 8
  %done = icmp eq i64 %left, 0
  br i1 %done, label %end, label %again
again:
  %next = add i64 %turns, 1
  call void @take_turn(ptr %words, i64 %next)
  br label %look
end:
  ret void
}

; Give way now and then: there may be fewer processors than threads.
define internal void @take_turn(ptr %words, i64 %turn) noinline {
entry:
  %part = and i64 %turn, 1023
  %due = icmp eq i64 %part, 0
  br i1 %due, label %look, label %end
look:
  %place = getelementptr i64, ptr %words, i64 24
  %word = load i64, ptr %place, align 8
  %none = icmp eq i64 %word, 0
  br i1 %none, label %end, label %yield
yield:
  %function = inttoptr i64 %word to ptr
  %ignored = call i32 %function()
  br label %end
end:
  ret void
}
