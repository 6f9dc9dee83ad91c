"""Effects of a rider on a vehicle other than at the handlebar. The gap workflow tries them on vehicles."""
