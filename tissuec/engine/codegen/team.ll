; How threads share a loop; see tissuec/engine/threads.py. Words of a team, all of 64 bits:
;   0: 65536 times the number of loops so far, and the next part of the present one
;   1: what to call, or 0 to end    2: its arguments    3: the number of parts, always the same
;  16: parts that are not done yet, or threads that have not ended yet
;  24: a function of the system that gives way, or 0

; Let all threads do parts of a loop; return when all parts are done.
define void @share_loop(ptr %words, ptr %job, ptr %arguments) noinline {
entry:
  %parts.place = getelementptr i64, ptr %words, i64 3
  %parts = load i64, ptr %parts.place, align 8
  call void @announce(ptr %words, i64 %parts, ptr %job, ptr %arguments)
  br label %own
own:
  %found = call i32 @do_part(ptr %words)
  %more = icmp ne i32 %found, 0
  br i1 %more, label %own, label %wait
wait:
  call void @wait(ptr %words)
  ret void
}

; End the other threads; return when they have ended.
define void @dismiss(ptr %words, i64 %others) {
  call void @announce(ptr %words, i64 %others, ptr null, ptr null)
  call void @wait(ptr %words)
  ; Leave no part for those who come next.
  %parts.place = getelementptr i64, ptr %words, i64 3
  %parts = load i64, ptr %parts.place, align 8
  %before = load atomic i64, ptr %words monotonic, align 8
  %loops = and i64 %before, -65536
  %closed = or i64 %loops, %parts
  store atomic i64 %closed, ptr %words release, align 8
  ret void
}

; Do parts of loops until the end.
define void @serve(ptr %words) {
entry:
  br label %look
look:
  %turns = phi i64 [ 0, %entry ], [ 0, %some ], [ %next, %again ]
  %found = call i32 @do_part(ptr %words)
  switch i32 %found, label %end [ i32 0, label %again
                                  i32 1, label %some ]
some:
  br label %look
again:
  %next = add i64 %turns, 1
  call void @take_turn(ptr %words, i64 %next)
  br label %look
end:
  ret void
}

define internal void @announce(ptr %words, i64 %pending, ptr %job, ptr %arguments) noinline {
  %job.place = getelementptr i64, ptr %words, i64 1
  %arguments.place = getelementptr i64, ptr %words, i64 2
  %pending.place = getelementptr i64, ptr %words, i64 16
  %job.word = ptrtoint ptr %job to i64
  %arguments.word = ptrtoint ptr %arguments to i64
  store atomic i64 %job.word, ptr %job.place monotonic, align 8
  store atomic i64 %arguments.word, ptr %arguments.place monotonic, align 8
  store atomic i64 %pending, ptr %pending.place monotonic, align 8
  %before = load atomic i64, ptr %words monotonic, align 8
  %number = lshr i64 %before, 16
  %following = add i64 %number, 1
  %begin = shl i64 %following, 16
  store atomic i64 %begin, ptr %words release, align 8
  ret void
}

; Do a part that nobody has taken: 0 if there was none, 1 if there was one, 2 if it was the end.
define internal i32 @do_part(ptr %words) noinline {
entry:
  %job.place = getelementptr i64, ptr %words, i64 1
  %arguments.place = getelementptr i64, ptr %words, i64 2
  %parts.place = getelementptr i64, ptr %words, i64 3
  %pending = getelementptr i64, ptr %words, i64 16
  %seen = load atomic i64, ptr %words acquire, align 8
  %parts = load i64, ptr %parts.place, align 8
  %part = and i64 %seen, 65535
  %open = icmp ult i64 %part, %parts
  br i1 %open, label %take, label %none
take:
  %job.word = load atomic i64, ptr %job.place monotonic, align 8
  %arguments.word = load atomic i64, ptr %arguments.place monotonic, align 8
  %taken = add i64 %seen, 1
  ; Fails if another thread took the part, also if another loop has begun since.
  %pair = cmpxchg ptr %words, i64 %seen, i64 %taken acq_rel monotonic, align 8
  %own = extractvalue { i64, i1 } %pair, 1
  br i1 %own, label %do, label %lost
do:
  %ends = icmp eq i64 %job.word, 0
  br i1 %ends, label %end, label %call
call:
  %job = inttoptr i64 %job.word to ptr
  %arguments = inttoptr i64 %arguments.word to ptr
  call void %job(i64 %part, i64 %parts, ptr %arguments)
  %before = atomicrmw sub ptr %pending, i64 1 release, align 8
  br label %lost
lost:
  ret i32 1
end:
  %before.end = atomicrmw sub ptr %pending, i64 1 release, align 8
  ret i32 2
none:
  ret i32 0
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
